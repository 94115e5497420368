# shellcheck shell=bash
# What has no package manager of Debian's: the wheel, the plugin's archive, the npm package. Sourced by
# check_installed.sh when the Debian packages are gone again, so that none of their libraries helps.

# The same sound live by every door: compares with the first that was made. Usage: same_live_sound FILE TOLERANCE
first_live=-
same_live_sound() {
  python3 compare.py "$1" "$first_live" "$2" || fail "the live sound is not that of $first_live"
  [ "$first_live" != - ] || first_live=$1
}
# The packages that needs.txt names for a file.
needs_of() { sed -n "s/^$1: //p" /packages/needs.txt; }

check_wheel() {
  local wheel
  wheel=$(basename /packages/*.whl)
  step "The Python wheel in a fresh environment"
  # shellcheck disable=SC2046
  install python3-venv python3-numpy $(needs_of "$wheel")
  python3 -m venv --system-site-packages environment
  environment/bin/pip install --quiet --no-index --no-deps "/packages/$wheel"
  (cd / && /check/environment/bin/python /check/wheel.py /check/moment.raw /check/whole.raw /check/wheel_live.raw)
  python3 compare.py whole.raw moment_there.wav 0 || fail "the wheel renders another sound than the program"
  same_live_sound wheel_live.raw 0
  environment/bin/pip uninstall --quiet --yes earpoint
  [ -z "$(find environment -iname '*earpoint*')" ] || fail "pip uninstall leaves files"
}

check_plugin() {
  local archive name
  archive=$(basename /packages/earpoint-plugin-*.tar.xz)
  name=${archive%.tar.xz}
  step "The plugin"
  # shellcheck disable=SC2046
  install xz-utils lilv-utils python3 $(needs_of "$archive")
  tar xf "/packages/$archive"
  [ -z "$(find "$name" ! -user root -o -type l -o -perm /022)" ] || fail "$archive has links, or files that others may write"
  mkdir lv2
  cp -r "$name/lv2/earpoint.lv2" lv2
  [ "$(LV2_PATH=/check/lv2 lv2ls)" = urn:earpoint:plugin ] || fail "lv2ls does not list the plugin"
  LV2_PATH=/check/lv2:/usr/lib/lv2 lv2apply -i moment.wav -o plugin.wav -c earpoint_x 1 -c earpoint_y -0.5 -c yaw 90 \
    -c speaker_given 1 -c speaker_x 2 -c speaker_y 0.25 -c speaker_z 0.125 urn:earpoint:plugin
  same_live_sound plugin.wav 0
  python3 - "$name" <<'PYTHON'
import ctypes, glob, sys
clap = ctypes.CDLL(glob.glob(f"./{sys.argv[1]}/clap/*.clap")[0])
assert ctypes.c_uint32.in_dll(clap, "clap_entry").value == 1, "CLAP's version"
vst3 = ctypes.CDLL(glob.glob(f"./{sys.argv[1]}/vst3/earpoint.vst3/Contents/*/earpoint.so")[0])
vst3.GetPluginFactory.restype = ctypes.c_void_p
assert vst3.ModuleEntry(None) and vst3.GetPluginFactory(), "VST3's factory"
PYTHON
  find "$name" -name gtf.safetensors | wc -l | grep -qx 3 || fail "a bundle lacks its models"
}

check_engine() {
  step "The npm package, in Debian's own Node"
  install nodejs python3
  node --version | grep -q '^v18\.' || fail "expected Node 18, found $(node --version)"
  # As npm installs a package that depends on nothing.
  mkdir -p node_modules/earpoint-engine
  tar xzf /packages/earpoint-engine-*.tgz -C node_modules/earpoint-engine --strip-components=1
  node engine.mjs moment.raw engine.raw
  # The tolerance of web/engine/test.
  same_live_sound engine.raw 1e-4
}

[ ! -e "$(echo /packages/*.whl)" ] || check_wheel
[ ! -e "$(echo /packages/earpoint-plugin-*.tar.xz)" ] || check_plugin
[ ! -e "$(echo /packages/earpoint-engine-*.tgz)" ] || check_engine
