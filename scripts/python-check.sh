#!/bin/sh
# Builds the wheel and tries it in fresh virtual environments: alone, then with pandas, polars, pyarrow and matplotlib; runs the
# tests of python/tests and the notebook, and prints the wheel's size and the time of `import seatrial`.
#
#   sh scripts/python-check.sh                 a wheel built for release, which must be below 20 MB
#   sh scripts/python-check.sh --debug         one of the debug profile, which is larger
#   sh scripts/python-check.sh --wheel FILE    a wheel that is there, which must be below 20 MB
#
# PYTHON names the interpreter (python3). Needs the network for pip. Without Python, pip or network it is skipped, with the
# reason; under CI it then fails.
set -eu
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
out=$PWD/out/python-check
most=20000000

skip() {
  echo "python-check: skipped, $1"
  [ -z "${CI:-}" ] || exit 1
  exit 0
}

usage() {
  echo "python-check: found \`$*\`, expected nothing, --debug or --wheel FILE" >&2
  exit 2
}

# An empty environment $1
fresh() {
  rm -rf "${out:?}/$1"
  "$python" -m venv "$out/$1" > "$out/venv.log" 2>&1 || skip "$python makes no virtual environment (out/python-check/venv.log)"
}

# What follows $1 into environment $1
get() {
  name=$1
  shift
  "$out/$name/bin/python" -m pip install --quiet --disable-pip-version-check "$@" > "$out/pip.log" 2>&1 && return
  tail -n 3 "$out/pip.log" >&2
  skip "pip cannot get $*; is there a network?"
}

profile=--release
wheel=
case $#:${1:-} in
  0:) ;;
  1:--debug) profile="--profile dev" ;;
  2:--wheel) wheel=$2 ;;
  *) usage "$@" ;;
esac
command -v "$python" > /dev/null || skip "no $python"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' || skip "$python is older than 3.10"
mkdir -p "$out"

if [ -z "$wheel" ]; then
  fresh build
  get build "maturin>=1.9,<2"
  rm -rf "$out/wheel"
  # shellcheck disable=SC2086 # two words
  (cd python && "$out/build/bin/maturin" build $profile --out "$out/wheel") > "$out/maturin.log" 2>&1 \
    || { tail -n 20 "$out/maturin.log" >&2; exit 1; }
  wheel=$(ls "$out"/wheel/*.whl)
fi
size=$(wc -c < "$wheel")
echo "python-check: $(basename "$wheel"), $((size / 1000)) kB"
[ "$profile" != --release ] || [ "$size" -lt $most ] || {
  echo "$wheel: size: found $size bytes, expected below $most; leave out what the program does not need" >&2
  exit 1
}

fresh bare
"$out/bare/bin/python" -m pip install --quiet --disable-pip-version-check --no-index "$wheel"
"$out/bare/bin/python" - << 'END'
import subprocess, sys
code = "import time; start = time.perf_counter(); import seatrial; print(time.perf_counter() - start)"
took = [float(subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout) for _ in range(5)]
print(f"python-check: import seatrial takes {1e3 * min(took):.1f} to {1e3 * max(took):.1f} ms")
END
(cd python && PYTHONDONTWRITEBYTECODE=1 "$out/bare/bin/python" -m unittest tests.test_bare)

fresh full
get full "seatrial[notebook] @ file://$(cd "$(dirname "$wheel")" && pwd)/$(basename "$wheel")"
(cd python && PYTHONDONTWRITEBYTECODE=1 "$out/full/bin/python" -m unittest tests.test_bare tests.test_frames)
"$out/full/bin/python" - python/notebook/from_ship_to_report.ipynb "$out" 2> "$out/notebook.log" << 'END' \
  || { tail -n 20 "$out/notebook.log" >&2; exit 1; }
import sys, time
from pathlib import Path
import nbformat
from nbclient import NotebookClient
path, out = Path(sys.argv[1]), Path(sys.argv[2])
start = time.monotonic()
notebook = nbformat.read(path, as_version=4)
NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(out)}}).execute()
nbformat.write(notebook, out / path.name)
print(f"python-check: {path.name} ran in {time.monotonic() - start:.0f} s, out/python-check/{path.name} has its figures")
END
# The blocks of the page, one after the other
rm -rf "$out/page" && mkdir "$out/page"
awk '$0 == "```python" { inside = 1; next } /^```/ { inside = 0 } inside' docs/python.md > "$out/page/page.py"
(cd "$out/page" && "$out/full/bin/python" page.py > printed) || { echo "docs/python.md: a block fails, see above" >&2; exit 1; }
echo "python-check: wheel, tests, notebook and the blocks of docs/python.md pass"
