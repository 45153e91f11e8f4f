#!/bin/sh
# Would today's programs write another row into docs/results.md? Its studies are made again with few realizations, and their page
# must be fixtures/results/few.md, which `make results` writes beside docs/results.md.
#
#   sh scripts/results-check.sh BIN [--write]     BIN: the folder of the programs, such as target/debug
#
# Studies of measured logs take part where their logs are; else their rows are not tried.
set -eu
cd "$(dirname "$0")/.."
bin=$1
out=out/results-check
kept=fixtures/results/few.md
few=20
# Of estimates that take longer
fewer=8
PATH="$PWD/$bin:$PATH"
export PATH
rm -rf "$out"
mkdir -p "$out" "$(dirname "$kept")"

# Runs what follows, which is to give $2 of study $1.
run() {
  study=$1 wanted=$2
  shift 2
  "$@" > "$out/said" 2>&1 || {
    cat "$out/said" >&2
    echo "results-check: found that $study does not run, expected $wanted; try make STUDY=pipelines/$study" >&2
    exit 1
  }
}

# Runs the study in the folder $1 up to its stage $2 into the folder $3 of results, with further flags.
made() {
  folder=$1 stage=$2 to=$3
  shift 3
  run "$to" "its $stage" seatrial run "$folder" --stage "$stage" --out "$out/$to" --quiet "$@"
}

# Trials of study $1, simulated, estimated by $2 and scored in memory.
trials() {
  made "pipelines/$1" monte-carlo "$1" --set "study.monte_carlo.estimator=$2" --set "study.monte_carlo.realizations=$few"
}

trials paper iv
trials generated iv
trials helsinki output-error
scenarios="" unknown=""
mkdir -p "$out/studies"
cp pipelines/scenarios/dictionary.toml "$out/studies/"
for name in white current-constant current-gauss-markov wind-bias; do
  mkdir -p "$out/studies/$name"
  cp pipelines/scenarios/$name/* "$out/studies/$name/"
  sed "s/^realizations *=.*/realizations = $fewer/" pipelines/scenarios/$name/campaign.toml > "$out/studies/$name/campaign.toml"
  made "$out/studies/$name" validate "scenarios/$name"
  scenarios="$scenarios $out/scenarios/$name"
done
run scenarios "a current as an unknown" make --no-print-directory -s BIN="$bin" FLAGS=--quiet \
  SCENARIO_STUDIES="$out/studies" SCENARIO_OUT="$out/scenarios" unknown
for name in "$out"/scenarios/*/unknown/*; do
  unknown="$unknown $name"
done
rounds=""
for name in sequential scenarios; do
  mkdir -p "$out/rounds/$name"
  seatrial monte-carlo --vessel pipelines/sequential/vessel.toml --dictionary pipelines/$name/dictionary.toml \
    --campaign pipelines/sequential/campaign.toml \
    --set campaign.rounds.realizations=$few --quiet --out "$out/rounds/$name/scores.parquet" > /dev/null
  rounds="$rounds $out/rounds/$name"
done
selections=""
for name in model-ship full-scale; do
  made pipelines/$name selection $name --set logs.seed=1 \
    --set "study.selection.realizations=$few"
  selections="$selections $out/$name/measured"
done
logs=""
for name in esso-osaka:esso_osaka kvlcc2:kvlcc2_hsva; do
  folder=../shared/data/${name#*:} study=${name%:*}
  if [ -d "$folder" ]; then
    made "pipelines/$study" estimate "$study" --logs "$folder"
    logs="$logs $out/$study/measured"
  fi
done
# shellcheck disable=SC2086  # Several folders each.
"$bin/examples/pages" results --studies "$out/paper" "$out/generated" "$out/helsinki" --scenarios $scenarios --unknown $unknown --rounds $rounds \
  --selections $selections ${logs:+--logs $logs} --out "$out/results.md"
if [ "${2:-}" = --write ]; then
  cp "$out/results.md" "$kept"
fi
# Rows of logs that are not here are left as they are, with the blank line above them.
page() {
  if [ -n "$logs" ]; then cat "$1"; else awk '
    /^## Measured logs/ { exit }
    /^$/ { blank++; next }
    { for (; blank; blank--) print ""; print }' "$1"; fi
}
page "$kept" > "$out/kept.md"
page "$out/results.md" > "$out/now.md"
if ! diff "$out/kept.md" "$out/now.md" > "$out/differences"; then
  echo "docs/results.md: found rows that today's programs write otherwise (with few realizations, < before, > now), expected none;" \
    "run make results" >&2
  cat "$out/differences" >&2
  exit 1
fi
[ -n "$logs" ] || echo "results-check: the rows of measured logs were not tried: there is no ../shared/data"
echo "docs/results.md: its studies with few realizations give the rows that they gave"
