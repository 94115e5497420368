#!/usr/bin/env bash
# Makes examples/clip.mp4, earpoints.json and the files that it names again, byte for byte: fetches the
# recorded voice (Debian's asterisk-core-sounds-it-g722, CC-BY-3.0, unpacked and not installed), packs the
# furniture, builds earpoint_make_clip and runs it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
EARPOINT_DATA_DIR=$folder/assets
export EARPOINT_DATA_DIR
./dev assets
(cd "$folder" && apt-get download -qq -o APT::Sandbox::User=root asterisk-core-sounds-it-g722)
dpkg-deb -x "$folder"/asterisk-core-sounds-it-g722_*.deb "$folder/voice"
ffmpeg -v error -f g722 -i "$folder/voice/usr/share/asterisk/sounds/it_IT_m_Carlo/demo-congrats.g722" \
  "$folder/voice.wav"
./dev build --target earpoint_make_clip
build/release/examples/earpoint_make_clip "$folder/voice.wav" examples
