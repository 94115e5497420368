#!/usr/bin/env bash
# Builds the wheel without network, installs it in a fresh environment and runs the tutorial there.
#
# usage: check_wheel.sh FOLDER [TEST...]
#   FOLDER  gets the wheel and the environment; what is there of them is replaced
#   TEST    modules of bindings/python/tests to run too; `all`: every one
# EARPOINT_BUILD_DIR, EARPOINT_PROGRAM  as setup.py and the tests have them
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
python=${EARPOINT_PYTHON_EXECUTABLE:-/usr/bin/python3}
mkdir -p "$1"
folder=$(cd "$1" && pwd)
shift
rm -rf "$folder/environment" "$folder"/earpoint-*.whl
"$python" -m build --no-isolation --wheel --outdir "$folder" "$root/bindings/python"
# NumPy and PyTorch are the system's.
"$python" -m venv --system-site-packages "$folder/environment"
installed=$folder/environment/bin/python
"$installed" -m pip install --quiet --no-index --no-deps "$folder"/earpoint-*.whl
cd "$folder"
place=$("$installed" -c 'import earpoint; print(earpoint.__file__)')
case "$place" in
  "$folder/environment"/*) ;;
  *) echo "check_wheel: earpoint is taken from $place" >&2; exit 1 ;;
esac
"$installed" "$root/examples/python/tutorial.py"
[ $# -eq 0 ] && exit
export PYTHONPATH=$root/bindings/python/tests
if [ "$1" = all ]; then
  "$installed" -m unittest discover --start-directory "$root/bindings/python/tests"
else
  "$installed" -m unittest "$@"
fi
