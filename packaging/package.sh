# shellcheck shell=bash
# ./dev package: the Debian packages, the Python wheel, the plugin's bundles and the npm package of the engine for
# browsers, and their check in a bare Debian. Sourced by ./dev. EARPOINT_PYTHON, EARPOINT_PLUGIN and EARPOINT_WASM=OFF
# in the environment leave out the last three, EARPOINT_IMAGE=OFF the Dockerfile.

# What makes packages; what installs a bare Debian.
package_packages=(dpkg-dev file binutils xz-utils)
check_packages=(debootstrap ffmpeg)
# Builds images without a daemon.
image_packages=(buildah)
package_folder=out/packages
package_version=$(sed -n 's/^project(earpoint VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
# The same sources give the same archives.
package_time=$(git log -1 --format=%ct 2>/dev/null || echo 0)

makes() { [ "${!1:-ON}" != OFF ]; }

# The packages of this version into out/packages.
make_packages() (
  ensure_packages "${package_packages[@]}"
  export EARPOINT_OPENCV=OFF
  local targets=(earpoint)
  ! makes EARPOINT_PYTHON || targets+=(earpoint_python)
  ! makes EARPOINT_PLUGIN || targets+=(earpoint_plugins)
  build package --target "${targets[@]}"
  build package-library --target earpoint_component_renderer
  rm -rf "$package_folder"
  mkdir -p "$package_folder"
  pack_debian
  ! makes EARPOINT_PYTHON || pack_wheel
  ! makes EARPOINT_PLUGIN || pack_plugin
  ! makes EARPOINT_WASM || pack_engine
  ls -l "$package_folder"
)

pack_debian() {
  say "Packing for Debian"
  cpack --config packaging/debian.cmake -B "$package_folder" >"$package_folder/cpack.log" 2>&1 ||
    { cat "$package_folder/cpack.log" >&2; fail "cpack failed"; }
  rm -rf "$package_folder/_CPack_Packages" "$package_folder/cpack.log"
}

pack_wheel() {
  say "Packing the Python wheel"
  EARPOINT_BUILD_DIR=$PWD/build/package SOURCE_DATE_EPOCH=$package_time \
    /usr/bin/python3 -m build --no-isolation --wheel --outdir "$package_folder" bindings/python >build/package/wheel.log ||
    { cat build/package/wheel.log >&2; fail "making the wheel failed"; }
  note_needs "$(wheel_file)" build/package/bindings/python/package/earpoint/_earpoint*.so
}
wheel_file() { basename "$package_folder"/earpoint-*.whl; }

# An archive of the three bundles, each complete with its models.
pack_plugin() {
  say "Packing the plugin"
  local name folder=build/package/archive
  name=earpoint-plugin-$package_version-linux-$(uname -m)
  rm -rf "$folder"
  copy_bundles package "$folder/$name"
  find "$folder" -type f \( -name '*.so' -o -name '*.clap' \) -exec strip --strip-unneeded {} +
  cp LICENSE packaging/plugin/README.txt "$folder/$name"
  # The models are in it three times: the dictionary spans them.
  tar -C "$folder" --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$package_time" --mode=u+w,go-w -c "$name" |
    xz -T1 --lzma2=preset=6,dict=64MiB >"$package_folder/$name.tar.xz"
  note_needs "$name.tar.xz" "$folder/$name"/lv2/earpoint.lv2/earpoint.so
}

pack_engine() {
  EARPOINT_PRESET=package build_engine
  cp "build/wasm/earpoint-engine-$package_version.tgz" "$package_folder"
}

# Writes down which Debian packages a file needs that no package manager installs with it: those of the shared libraries
# that its binary is linked with. Usage: note_needs FILE BINARY
note_needs() {
  local needs folder=build/package/needs
  mkdir -p "$folder/debian"
  printf 'Source: earpoint\n\nPackage: earpoint\nArchitecture: any\n' >"$folder/debian/control"
  # It warns of symbols that the host of a module defines.
  needs=$(cd "$folder" && dpkg-shlibdeps --warnings=0 -O "$OLDPWD/$2" 2>log) ||
    { cat "$folder/log" >&2; fail "dpkg-shlibdeps failed for $2"; }
  # Names alone, and of alternatives the first.
  needs=$(sed 's/^shlibs:Depends=//; s/ ([^)]*)//g; s/ | [^,]*//g; s/,//g' <<<"$needs")
  [ -n "$needs" ] || fail "$2 needs no library, which cannot be"
  echo "$1: $needs" >>"$package_folder/needs.txt"
}

# Installs the packages in a bare Debian 12 and uses them there. Needs root, as debootstrap does.
check_packages() {
  [ "$(id -u)" -eq 0 ] || fail "package --check needs root: debootstrap and chroot"
  ensure_packages "${check_packages[@]}"
  if ! compgen -G "$package_folder/*.deb" >/dev/null; then make_packages; fi
  bare_debian
  local root=build/package-check/root
  rm -rf "$root"
  cp -a build/package-check/bare "$root"
  mkdir -p "$root/packages" "$root/check"
  cp "$package_folder"/*.deb "$root/packages"
  copy_part EARPOINT_PYTHON "$package_folder"/*.whl "$root/packages"
  copy_part EARPOINT_PLUGIN "$package_folder"/earpoint-plugin-*.tar.xz "$root/packages"
  copy_part EARPOINT_WASM "$package_folder"/earpoint-engine-*.tgz "$root/packages"
  [ ! -e "$package_folder/needs.txt" ] || cp "$package_folder/needs.txt" "$root/packages"
  cp examples/clip.mp4 examples/c/listen.c packaging/check/* "$root/check"
  ffmpeg -v error -y -i examples/clip.mp4 -vn -c:a pcm_f32le "$root/check/clip.wav"
  ffmpeg -v error -y -i examples/clip.mp4 -vn -t 2 -c:a pcm_f32le "$root/check/moment.wav"
  ffmpeg -v error -y -i "$root/check/moment.wav" -f f32le "$root/check/moment.raw"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  say "Installing the packages there and using them"
  chroot "$root" /bin/bash /check/check_installed.sh || fail "the packages do not work in a bare Debian"
  rm -rf "$root"
  ! makes EARPOINT_IMAGE || check_image
}

# Builds packaging/Dockerfile on the bare Debian, which stands in for Docker's image of it, and renders in the result.
check_image() (
  ensure_packages "${image_packages[@]}"
  local folder=$PWD/build/package-check/image container entry
  local tool=(buildah --root "$folder/storage" --runroot "$folder/run" --storage-driver vfs)
  rm -rf "$folder"
  mkdir -p "$folder/shared"
  trap '"${tool[@]}" rm --all >/dev/null 2>&1 || true; rm -rf "$folder"' EXIT
  say "Building an image by packaging/Dockerfile"
  tar -C build/package-check/bare -cf "$folder/bare.tar" .
  container=$("${tool[@]}" from scratch)
  "${tool[@]}" add -q "$container" "$folder/bare.tar" / >/dev/null
  "${tool[@]}" commit -q "$container" "$(sed -n 's/^FROM /docker.io\/library\//p' packaging/Dockerfile)" >/dev/null
  "${tool[@]}" bud -q --isolation chroot --pull-never -f packaging/Dockerfile -t earpoint . >"$folder/log" 2>&1 ||
    { cat "$folder/log" >&2; fail "packaging/Dockerfile does not build"; }
  say "Rendering in it"
  cp examples/clip.mp4 "$folder/shared"
  entry=$("${tool[@]}" inspect --type image --format '{{index .OCIv1.Config.Entrypoint 0}}' localhost/earpoint)
  container=$("${tool[@]}" from --pull-never localhost/earpoint)
  "${tool[@]}" run --isolation chroot -v "$folder/shared:/work" "$container" -- "$entry" render clip.mp4 \
    --speaker 1.89,0.2,0.15 --translate 1,-0.5,0 --yaw 90 -o there.wav --quiet || fail "the image does not render"
  [ "$(stat -c %s "$folder/shared/there.wav")" -gt 100000 ] || fail "what the image rendered is too short"
)

# Copies a file, unless VARIABLE is OFF. Usage: copy_part VARIABLE FILE FOLDER
copy_part() {
  makes "$1" || return 0
  [ -e "$2" ] || fail "there is no $2: run ./dev package, or set $1=OFF to check without it"
  cp "$2" "$3"
}

# A bare Debian 12 in build/package-check/bare, fetched once.
bare_debian() {
  local bare=build/package-check/bare
  [ ! -x "$bare/bin/sh" ] || return 0
  say "Fetching a bare Debian 12"
  rm -rf "$bare"
  mkdir -p "$bare"
  debootstrap --variant=minbase bookworm "$bare" "$(debian_mirror)" >build/package-check/debootstrap.log ||
    fail "debootstrap failed; see build/package-check/debootstrap.log"
}

# The mirror of this machine's apt.
# shellcheck disable=SC2016
debian_mirror() {
  apt-get indextargets --format '$(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' |
    awk '$2 == "bookworm" && $3 == "main" { print $1; exit }'
}
