#!/bin/sh
# Runs a sweep; what is there already is not made again. `make sweep` calls it.
#   Usage: sh pipelines/sweep/run.sh CONFIG.YAML OUT PROFILE BIN [snakemake's flags]
#   SWEEP_VENV: where Snakemake is or will be put (default: out/sweep-venv); SWEEP_PYTHON: the Python to make it with.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
sweep=$(realpath "$1") out=$2 profile=$here/profiles/$3 bin=$(realpath "$4")
kind=$3
shift 4
venv=${SWEEP_VENV:-out/sweep-venv} python=${SWEEP_PYTHON:-python3}

refuse() {
  echo "error: $1" >&2
  exit 3
}

case $sweep$out$bin in
  *[{}]*) refuse "$sweep, $out: found a name with { or }, expected none, which Snakemake takes for a pattern; rename it" ;;
esac
case $sweep in
  *.toml) refuse "$sweep: found a sweep in TOML, expected one like pipelines/sweep/config.yaml; write its study and grid into such a file" ;;
esac
[ -f "$sweep" ] || refuse "$sweep: found no such file, expected one like pipelines/sweep/config.yaml; write it"
[ -d "$profile" ] || refuse "profile: found $kind, expected $(ls "$here/profiles" | paste -sd ' '); name one"
if [ "$kind" = slurm ]; then
  for program in sbatch squeue scancel; do
    command -v $program > /dev/null || refuse "profile slurm: found no $program, expected a machine that submits to Slurm; \
install Slurm's client, or take PROFILE=local"
  done
  squeue --noheader > /dev/null 2>&1 || refuse "profile slurm: found no answer of squeue, expected a Slurm controller in reach; \
start it, or take PROFILE=local"
fi

mkdir -p "$out" "$(dirname "$venv")"
out=$(realpath "$out")
exec 9> "$out/.running"
flock --timeout 20 9 || refuse "$out: found another run of this sweep, expected none; wait for it, or end it"

if ! cmp -s "$here/requirements.txt" "$venv/installed.txt"; then
  command -v "$python" > /dev/null ||
    refuse "$python: found none, expected Python 3.11 or later; install it, or name one with SWEEP_PYTHON"
  "$python" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2> /dev/null ||
    refuse "$python: found $("$python" --version 2>&1), expected Python 3.11 or later with venv; name one with SWEEP_PYTHON"
  echo "$venv: installing Snakemake" >&2
  "$python" -m venv --clear "$venv"
  "$venv/bin/pip" install --quiet --disable-pip-version-check --retries 2 --timeout 20 --requirement "$here/requirements.txt" ||
    refuse "$venv: found no way to install requirements.txt, expected PyPI in reach; see above"
  cp "$here/requirements.txt" "$venv/installed.txt"
fi
venv=$(realpath "$venv")

PATH="$profile:$venv/bin:$PATH"
export PATH
run() {
  snakemake --snakefile "$here/Snakefile" --directory "$out" --configfile "$sweep" --config "sweep=$sweep" "out=$out" "bin=$bin" \
    --profile "$profile" "$@"
}
# Whoever was killed has left a lock; that nobody else runs is known from above.
if [ -n "$(ls -A "$out/.snakemake/locks" 2> /dev/null)" ]; then run --unlock --quiet all; fi
run --keep-going --rerun-incomplete --retries 2 --scheduler greedy "$@" --quiet rules host reason
echo "Table: $out/sweep.csv"
