#!/usr/bin/env bash
# Makes examples/clip.mp4 and the true sounds beside it anew: installs the recorded voice (Debian's
# asterisk-core-sounds-en-g722, CC-BY-SA-3.0), builds the maker, runs it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
voice=/usr/share/asterisk/sounds/en_US_f_Allison/demo-moreinfo.g722
[ -f "$voice" ] || apt-get install -y -qq --no-install-recommends asterisk-core-sounds-en-g722 >/dev/null
./dev build --target earpoint_make_clip
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
ffmpeg -v error -f g722 -i "$voice" "$folder/voice.wav"
build/release/examples/earpoint_make_clip "$folder/voice.wav" examples
