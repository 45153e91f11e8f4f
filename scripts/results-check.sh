#!/bin/sh
# Would today's programs write another row into docs/results.md? Some realizations of every study that the page tells of are
# made again; what the stages say of them must stand in docs/results-check.txt, which `make results` writes with the page.
#
#   sh scripts/results-check.sh BIN [--write]     BIN: the folder of the programs, such as target/debug
#
# Studies of measured logs take part where their logs are.
set -eu
cd "$(dirname "$0")/.."
bin=$1
out=out/results-check
kept=docs/results-check.txt
few=20
PATH="$PWD/$bin:$PATH"
export PATH
rm -rf "$out"
mkdir -p "$out"

# What the last stage says on its way to the target $2 of study $1, with further variables of make, but for where it writes.
row() {
  study=$1 target=$2
  shift 2
  said=$(make --no-print-directory -s BIN="$bin" STUDY="pipelines/$study" OUT="$out/$study" FLAGS=--quiet "$@" "$out/$study/$target") ||
    { echo "results-check: $study does not run, expected $target of it; run make STUDY=pipelines/$study" >&2; exit 1; }
  last "$study $target" "$said"
}

# The last line of $2, which $1 says.
last() {
  echo "$1: $(echo "$2" | tail -n 1 | sed 's/^[^:]*: //')" >> "$out/said"
}

trials() {
  row "$1" tally.json MONTE_CARLO=yes ESTIMATE_FLAGS="$2 --realizations $few"
}

trials paper "--estimator iv"
trials generated "--estimator iv"
trials helsinki "--estimator output-error"
row helsinki plan.json
for name in white current-constant current-gauss-markov wind-bias; do
  study=pipelines/scenarios/$name folder=$out/scenarios/$name
  trials "scenarios/$name" "--estimator ls,iv,refined-iv,output-error,prediction-error"
  seatrial simulate campaign --vessel $study/vessel.toml --dictionary "$(sed -n 's/^DICTIONARY *:*= *//p' $study/study.mk)" \
    --campaign $study/campaign.toml --design "$folder/design.json" --set campaign.realizations=$few --quiet --out "$folder/campaign.parquet" > /dev/null
  for way in "output-error --unknown-current earth" "output-error --unknown-current drifting" "output-error --unknown-wind earth" \
    "output-error --intercepts none" prediction-error; do
    # shellcheck disable=SC2086  # A way is several words.
    last "scenarios/$name $way" "$(seatrial estimate --vessel $study/vessel.toml --trajectories "$folder/campaign.parquet" \
      --estimator $way --quiet --out "$folder/estimates.parquet")"
  done
done
for name in sequential paper; do
  last "rounds $name" "$(seatrial sequential --vessel pipelines/sequential/vessel.toml --dictionary pipelines/$name/dictionary.toml \
    --campaign pipelines/sequential/campaign.toml --config pipelines/sequential/sequential.toml \
    --set sequential.realizations=$few --quiet --out "$out/$name.parquet")"
done
for name in model-ship full-scale; do
  row $name measured/selection.parquet SEED_FLAGS="--seed 1" \
    SELECTION_FLAGS="--estimator iv --nominal least-squares --realizations $few"
done
for name in esso_osaka kvlcc2_hsva; do
  if [ -d "../shared/data/$name" ]; then
    row "$(echo $name | sed 's/_hsva//; s/_/-/')" measured/crossval.json LOGS="../shared/data/$name"
  else
    grep "^$(echo $name | sed 's/_hsva//; s/_/-/') " "$kept" >> "$out/said" || true
    echo "results-check: ../shared/data/$name is not there: its rows are not tried"
  fi
done

if [ "${2:-}" = --write ]; then
  cp "$out/said" "$kept"
elif ! diff "$kept" "$out/said" > "$out/differences"; then
  echo "docs/results.md: found rows that today's programs write otherwise (< as they were, > as they are), expected none; run make results" >&2
  cat "$out/differences" >&2
  exit 1
fi
echo "docs/results.md: $(wc -l < "$out/said") rows tried with $few realizations, all as they were"
