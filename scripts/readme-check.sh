#!/bin/sh
# Runs what README.md says: the stages' commands of its sh blocks, with the built programs in front of PATH, and the
# paper's study, whose shares must be those of README's table.   Usage: sh scripts/readme-check.sh target/release
set -eu
cd "$(dirname "$0")/.."
PATH="$PWD/$1:$PATH"
export PATH
mkdir -p out
commands=out/readme-commands.sh
awk '/^```sh$/ { inside = 1; next } /^```/ { inside = 0 } inside && !/^(make|cp)/' README.md > "$commands"
[ -s "$commands" ] || { echo "README.md: found no commands, expected sh blocks with stages" >&2; exit 1; }
sh -eu "$commands"
make --no-print-directory BIN="$1" study
for design in optimized random; do
  for error in parameter_error simulation_error; do
    value=$(awk -v design="\"$design\"" -v key="\"${error}_share\":" \
      '$1 == "\"design\":" { own = ($2 == design ",") } own && $1 == key { sub(",", "", $2); printf "%.1f %%", 100 * $2 }' \
      out/paper/validation.json)
    case $design in optimized) column=3 ;; random) column=5 ;; esac
    said=$(awk -F'|' -v name="$(echo $error | tr _ ' ') below" -v column=$column \
      'index($2, name) { gsub(/^ +| +$/, "", $column); print $column }' README.md)
    [ "$value" = "$said" ] || { echo "README.md: $design, $error: found $said, expected $value; correct the table" >&2; exit 1; }
  done
done
echo "README.md: commands run, table holds"
