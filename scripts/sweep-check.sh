#!/usr/bin/env bash
# Runs a small sweep on this machine while the disk is full for one cell, and again with its master killed and started again. With
# `slurm` it has 24 cells, and also runs on a Slurm that the script starts, there with a job cancelled and with the master killed.
# All must give the same table of the same tallies. Says what it skips and why.
#   Usage: bash scripts/sweep-check.sh BIN [slurm]     BIN: the folder of the programs
set -euo pipefail
cd "$(dirname "$0")/.."
bin=$(realpath "$1") work=$PWD/out/sweep-check
. scripts/one-machine-slurm.sh
export SWEEP_VENV=${SWEEP_VENV:-out/sweep-venv}

rm -rf "$work"
mkdir -p "$work/bin"
# Where the first value is refused with the files, and the last by the stage: no ship sails such a sea.
currents="-1.0, 0.158, 14.0" noises="0.05, 0.158" refusals=4
[ "${2:-}" = slurm ] && currents="-1.0, 0.05, 0.1, 0.158, 0.25, 14.0" noises="0.01, 0.05, 0.158, 0.3" refusals=8
cat > "$work/config.yaml" << YAML
study: ../../pipelines/smoke
flags: ['--set=study.monte_carlo={ estimator = ["iv", "ls"], realizations = 16 }', --stage=monte-carlo]
grid:
  campaign.current.std_m_s: [$currents]
  campaign.measurement.std_r_rad_s: [$noises]
YAML
# The program; one cell finds the disk full, once.
cat > "$work/bin/seatrial" << SCRIPT
#!/bin/sh
case "\$*" in *cells/cell-00003*) if mkdir "$work/full" 2> /dev/null; then trap '' XFSZ; ulimit -f 1; fi ;; esac
exec "$bin/seatrial" "\$@"
SCRIPT
chmod +x "$work/bin/seatrial"

failed() { echo "sweep check: $1; see $work" >&2; exit 1; }

# refused WORDS COMMAND...: it ends with 3 and one line that says these words, and computes nothing.
refused() {
  local says=$1 code=0
  shift
  "$@" > /dev/null 2> "$work/refused.log" || code=$?
  [ $code = 3 ] && [ "$(wc -l < "$work/refused.log")" = 1 ] && grep -q "$says" "$work/refused.log" ||
    failed "exit code $code, $(head -3 "$work/refused.log"): expected a refusal with: $says"
  [ ! -e "$work/refused/cells" ] || failed "$says: something was computed"
}
run=(sh pipelines/sweep/run.sh "$work/config.yaml" "$work/refused")
refused "profile: found moon, expected local slurm" "${run[@]}" moon "$bin"
refused "profile slurm: found no" env SLURM_CONF=/nonexistent "${run[@]}" slurm "$bin"
refused "no-python: found none, expected Python" env SWEEP_PYTHON=no-python SWEEP_VENV="$work/none" "${run[@]}" local "$bin"

skip() { echo "sweep check: skipped${2:+ on Slurm}: $1"; exit 0; }
python=${SWEEP_PYTHON:-python3}
if ! cmp -s pipelines/sweep/requirements.txt "$SWEEP_VENV/installed.txt"; then
  "$python" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' 2> /dev/null || skip "no Python 3.11 with venv"
fi

# sweep NAME PROFILE BIN FLAGS...: a sweep into its own folder.
sweep() {
  local name=$1 profile=$2 programs=$3
  shift 3
  sh pipelines/sweep/run.sh "$work/config.yaml" "$work/$name" "$profile" "$programs" "$@" >> "$work/$name.log" 2>&1
}
digests() {
  (cd "$work/$1" && sha256sum cells/*/validation.json sweep.csv) > "$work/$1.sha256"
  cmp -s "$work/$1.sha256" "$work/${2:-$1}.sha256" || { diff "$work/$1.sha256" "$work/${2:-$1}.sha256"; failed "$1: other digests"; }
  echo "sweep check: $1: $(wc -l < "$work/$1.sha256") files, $SECONDS s"
}
trap 'code=$?; [ $code = 0 ] || tail -n 40 "$work"/*.log >&2' EXIT
# wait_for COMMAND: until it says yes; some NAME: that has ended a cell, and not all.
wait_for() { for _ in $(seq 600); do if "$@"; then return 0; fi; sleep 0.1; done; failed "waited in vain: $*"; }
some() { ls "$work/$1/cells"/cell-*.json > /dev/null 2>&1; }
# killed NAME PROFILE FLAGS...: a sweep whose master is killed, with all that it runs on this machine, and started again.
killed() {
  setsid bash -c "$(declare -f sweep); work=$work; sweep $1 $2 '$bin' ${*:3}" &
  local master=$!
  wait_for some "$1"
  kill -9 -- -"$master"
  wait "$master" 2> /dev/null || true
  [ ! -e "$work/$1/sweep.csv" ] || failed "$1: was done before it was killed"
  sweep "$1" "$2" "$bin" "${@:3}"
}

sweep local local "$work/bin" || { grep -q "PyPI in reach" "$work/local.log" && skip "no PyPI in reach"; failed "local: see its log"; }
[ -d "$work/full" ] && [ "$(grep -c '^Trying to restart job' "$work/local.log")" = 1 ] ||
  failed "local: not one job failed, that on the full disk"
[ "$(tail -n +2 "$work/local/sweep.csv" | grep -vc ',$')" = $refusals ] || failed "local: not $refusals refused cells"
grep -q '^cell-00000,-1.0,0.05,,.*campaign.toml: `current.std_m_s`: found -1' "$work/local/sweep.csv" || failed "local: no refusal named"
digests local
killed killed local
digests killed local

# A key that no file has is refused in every cell.
sed 's/current.std_m_s/current.std_ms/' "$work/config.yaml" > "$work/misspelt.yaml"
if sh pipelines/sweep/run.sh "$work/misspelt.yaml" "$work/misspelt" local "$bin" > "$work/misspelt.log" 2>&1; then
  failed "misspelt: it ended well"
fi
grep -q 'found every cell refused.*key `std_ms`.*did you mean `std_m_s`' "$work/misspelt.log" || failed "misspelt: no refusal"
[ "${2:-}" = slurm ] || { echo "sweep check: not on Slurm, which make nightly tries"; exit 0; }

missing=$(slurm_missing)
[ -z "$missing" ] || skip "$missing (Debian: slurmctld slurmd slurm-client munge)" slurm
mkdir -p "$work/daemons"
trap 'code=$?; slurm_stop; [ $code = 0 ] || tail -n 40 "$work"/*.log "$work"/daemons/*.log >&2' EXIT
slurm_start "$work/daemons" || skip "it does not start here" slurm
echo "sweep check: Slurm: an idle node, $SECONDS s"
# Jobs of eight cells: most of a job's time is Snakemake's own start.
few=(--groups cell=few --group-components few=8 --seconds-between-status-checks 1)
sweep slurm slurm "$bin" "${few[@]}"
digests slurm local
sweep cancelled slurm "$bin" "${few[@]}" &
master=$!
job() { squeue --noheader --states=RUNNING,PENDING --format=%i | head -1; }
cancel() { local id; id=$(job); [ -n "$id" ] && some cancelled && scancel "$id" && echo "sweep check: job $id is cancelled"; }
wait_for cancel
wait "$master"
squeue --noheader --states=CANCELLED | grep -q . || failed "cancelled: no job was"
digests cancelled local
killed slurm-killed slurm "${few[@]}"
digests slurm-killed local
