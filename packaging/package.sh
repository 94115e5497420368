# shellcheck shell=bash
# ./dev package: the Debian packages, and their check in a bare Debian. Sourced by ./dev.

# What makes packages; what installs a bare Debian.
package_packages=(dpkg-dev file)
check_packages=(debootstrap ffmpeg)
package_folder=out/packages

# The packages of this version into out/packages. Other doors join here: each puts its own file beside the .deb files.
make_packages() {
  ensure_packages "${package_packages[@]}"
  EARPOINT_OPENCV=OFF build package --target earpoint
  EARPOINT_OPENCV=OFF build package-library --target earpoint_component_renderer
  rm -rf "$package_folder"
  mkdir -p "$package_folder"
  say "Packing"
  cpack --config packaging/debian.cmake -B "$package_folder" >"$package_folder/cpack.log" 2>&1 || { cat "$package_folder/cpack.log" >&2; fail "cpack failed"; }
  rm -rf "$package_folder/_CPack_Packages" "$package_folder/cpack.log"
  # Room for the Python wheel, the LV2 bundle and the npm tarball: their commands write into the same folder.
  ls -l "$package_folder"
}

# Installs the packages in a bare Debian 12 and uses them there. Needs root, as debootstrap does.
check_packages() {
  [ "$(id -u)" -eq 0 ] || fail "package --check needs root: debootstrap and chroot"
  ensure_packages "${check_packages[@]}"
  compgen -G "$package_folder/*.deb" >/dev/null || make_packages
  local bare=build/package-check/bare root=build/package-check/root
  if [ ! -x "$bare/bin/sh" ]; then
    say "Fetching a bare Debian 12"
    rm -rf "$bare"
    mkdir -p "$bare"
    debootstrap --variant=minbase bookworm "$bare" "$(debian_mirror)" >build/package-check/debootstrap.log ||
      fail "debootstrap failed; see build/package-check/debootstrap.log"
  fi
  rm -rf "$root"
  cp -a "$bare" "$root"
  mkdir -p "$root/packages" "$root/check"
  cp "$package_folder"/*.deb "$root/packages"
  cp examples/clip.mp4 examples/c/listen.c packaging/check_installed.sh "$root/check"
  ffmpeg -v error -y -i examples/clip.mp4 -vn -c:a pcm_f32le "$root/check/clip.wav"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  say "Installing the packages there and using them"
  chroot "$root" /bin/bash /check/check_installed.sh || fail "the packages do not work in a bare Debian"
  rm -rf "$root"
}

# The mirror of this machine's apt.
debian_mirror() {
  apt-get indextargets --format '$(REPO_URI) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' |
    awk '$2 == "bookworm" && $3 == "main" { print $1; exit }'
}
