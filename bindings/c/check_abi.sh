#!/usr/bin/env bash
# Holds the binary interface of libearpoint.so's C functions against the recorded one, earpoint.abi: programs that were
# linked with the recorded one must run with this library. Any difference fails; --record records it instead.
#
# A difference that adds is recorded with --record. One that breaks (a function or member removed, moved or of another
# type) needs a new minor version, whose library has another name (soname), and then --record.
#
# usage: check_abi.sh LIBRARY [--record]
set -euo pipefail
library=$1
here=$(dirname "${BASH_SOURCE[0]}")
recorded=$here/earpoint.abi
command -v abidw >/dev/null || { echo "skipped: abidw is not installed; ./dev shared installs it"; exit 77; }
found=$(mktemp)
trap 'rm -f "$found"' EXIT

# No name that other libraries may have too. Weak ones are the standard library's templates, which all libraries share.
if nm -D --defined-only "$library" | awk '$2 ~ /^[TDBR]$/ {print $3}' | grep -vE '^earpoint_|^_Z.*8earpoint'; then
  echo "check_abi: $library exports the names above, which do not have earpoint in them" >&2
  exit 1
fi

# Of the C functions and the types in earpoint.h alone: what is behind the handles may change.
abidw --suppressions "$here/earpoint.abignore" --headers-dir "$here/include" --drop-private-types \
  --exported-interfaces-only --type-id-style hash --no-elf-needed --no-parameter-names --no-corpus-path \
  --no-comp-dir-path --no-show-locs --out-file "$found" "$library"
grep -q "class-decl name='earpoint_request'" "$found" ||
  { echo "check_abi: $library has no debug information of earpoint.h" >&2; exit 1; }

if [ "${2:-}" = --record ]; then
  cp "$found" "$recorded"
  echo "check_abi: recorded $recorded"
elif ! abidiff "$recorded" "$found"; then
  echo "check_abi: the C interface is not the recorded one. If programs linked before run on, record it:" >&2
  echo "check_abi: ./dev shared --record-abi. If they do not, undo it, or raise the minor version first." >&2
  exit 1
fi
