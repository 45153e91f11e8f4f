#!/bin/sh
# Runs what README.md and docs/ say: the stages' commands of their sh blocks, with the built programs in front of PATH, and
# the paper's study, of which README.md and docs/results.md must have what its documents say.
#   Usage: sh scripts/readme-check.sh target/release
set -eu
cd "$(dirname "$0")/.."
PATH="$PWD/$1:$PATH"
export PATH
mkdir -p out
commands=out/readme-commands.sh
pages="README.md docs/own-ship.md docs/physics.md docs/trials.md docs/own-chart.md docs/own-cluster.md docs/own-logs.md docs/design.md docs/estimators.md docs/export.md"
for page in $pages; do
  awk '/^```sh$/ { inside = 1; next } /^```/ { inside = 0 } inside && !/^(make|cp|cargo)/' "$page"
done > "$commands"
[ -s "$commands" ] || { echo "README.md: found no commands, expected sh blocks with stages" >&2; exit 1; }
sh -eu "$commands"
make --no-print-directory BIN="$1" study
"$1/examples/pages" results --studies out/paper --written pipelines --out out/readme/results.md
grep '^| paper |' out/readme/results.md > out/readme/rows
for page in README.md docs/results.md; do
  while read -r row; do
    grep -qxF "$row" "$page" || { echo "$page: found no such row, expected: $row; make results writes it" >&2; exit 1; }
  done < out/readme/rows
done
echo "README.md, docs/: commands run, tables hold"
