#!/bin/sh
# Puts what docs/results.md says of the paper's study between the marks in README.md.
#   Usage: sh scripts/front-table.sh docs/results.md README.md
set -eu
table=$(awk '/^## / { inside = ($2 == "Designs") } inside && (/^\| study / || /^\|---/ || /^\| paper \|/)' "$1")
[ -n "$table" ] || { echo "$1: found no row of the paper's study, expected a table of designs" >&2; exit 1; }
TABLE=$table awk '
  /^<!-- end of results -->$/ { inside = 0 }
  !inside { print }
  /^<!-- results -->$/ { inside = 1; print ENVIRON["TABLE"] }' "$2" > "$2.new"
mv "$2.new" "$2"
