#!/usr/bin/env bash
# Runs in a bare Debian with /packages/*.deb and /check: installs each package and uses what it brings. ./dev package
# --check starts it.
set -euo pipefail
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
cd /check

step() { printf '%s\n' "-- $*"; }
fail() { printf 'check: %s\n' "$*" >&2; exit 1; }
# apt's own messages only if it fails.
quiet() { "$@" >/check/log 2>&1 || { cat /check/log >&2; fail "failed: $*"; }; }
install() { quiet apt-get install -y -q --no-install-recommends "$@"; }
package() {
  local found=(/packages/"$1"_*.deb)
  [ -e "${found[0]}" ] || fail "there is no package $1"
  printf '%s\n' "${found[0]}"
}

quiet apt-get update -q

step "Files of every package"
for deb in /packages/*.deb; do
  name=$(dpkg-deb -f "$deb" Package)
  dpkg-deb -c "$deb" >contents
  grep -q "/usr/share/doc/$name/copyright$" contents || fail "$name has no copyright"
  # Everything under /usr, owned by root, and nobody else may write it.
  awk '{print $6}' contents | grep -vE '^\./$|^\./usr/' && fail "$name has files outside of /usr"
  grep -q '/usr/local/' contents && fail "$name has files in /usr/local"
  awk '$1 !~ /^l/ && ($2 != "root/root" || substr($1, 9, 1) == "w")' contents | grep . &&
    fail "$name has files that others may write"
  dpkg-deb -f "$deb" Description | grep -q . || fail "$name has no description"
done

step "The program"
install "$(package earpoint-models)" "$(package earpoint)"
earpoint --version
earpoint render clip.mp4 --speaker 1.89,0.2,0.15 --translate 1.0,-0.5,0 --yaw 90 -o there.wav --quiet
earpoint evaluate --help >/dev/null
[ "$(stat -c %s there.wav)" -gt 100000 ] || fail "there.wav is too short"
# What check_archives.sh compares with.
earpoint render moment.wav --recording binaural --speaker 2,0.25,0.125 --translate 1,-0.5,0 --yaw 90 -o moment_there.wav --quiet

step "Manual page and completions"
install man-db zsh fish bash-completion
gzip -dc /usr/share/man/man1/earpoint.1.gz >earpoint.1
man --warnings -l earpoint.1 >manual.txt 2>warnings
[ ! -s warnings ] || { cat warnings >&2; fail "man warns of the page"; }
grep -q 'earpoint render' manual.txt || fail "the page lacks earpoint render"
bash -c 'source /usr/share/bash-completion/bash_completion
  _completion_loader earpoint || true
  COMP_WORDS=(earpoint render --texture n) COMP_CWORD=3
  _earpoint earpoint; [ "${COMPREPLY[*]}" = natural ]' || fail "bash does not complete"
[ "$(fish -c 'complete -C "earpoint render --texture n"')" = natural ] || fail "fish does not complete"
zsh -fc 'autoload -Uz compinit && compinit -u && [[ $_comps[earpoint] == _earpoint ]] && autoload -Uz +X _earpoint' ||
  fail "zsh does not know the completion"

step "The library for C"
install "$(package libearpoint0.1)" "$(package libearpoint-dev)" gcc libc6-dev libsndfile1-dev pkg-config
# shellcheck disable=SC2046
gcc -std=c99 -Wall -Wextra -pedantic -Werror listen.c -o listen $(pkg-config --cflags --libs earpoint sndfile)
./listen clip.wav whole.wav live.wav
# What is silent is refused.
earpoint render whole.wav --model input --yaw 0 -o again.wav --quiet
earpoint render live.wav --model input --yaw 0 -o again.wav --quiet

step "Debian's own checker"
install lintian
# These packages are not of Debian's archive, and ldconfig's call is CPack's.
lintian --allow-root --fail-on error,warning --suppress-tags initial-upload-closes-no-bugs,maintscript-calls-ldconfig \
  /packages/*.deb || fail "lintian finds faults"

step "Removing the packages"
dpkg -L libearpoint-dev libearpoint0.1 earpoint earpoint-models >installed
quiet apt-get purge -y -q --autoremove libearpoint-dev libearpoint0.1 earpoint earpoint-models
while read -r path; do
  if [ -e "$path" ] && [ ! -d "$path" ]; then fail "$path was left behind"; fi
done <installed
left=$(find / -xdev -iname '*earpoint*' -not -path '/check/*' -not -path '/packages/*')
[ -z "$left" ] || fail "left behind: $left"
if ldconfig -p | grep -q earpoint; then fail "the linker's cache still has the library"; fi

# shellcheck source=packaging/check/check_archives.sh
source /check/check_archives.sh
echo "All packages work."
