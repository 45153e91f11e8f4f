#!/bin/sh
# Runs the commands of the book's tutorial, in a folder of their own without this repository, and checks what it says of them: lines of
# its text blocks are printed, and the numbers in it are those of the documents that the commands write.
#   Usage: sh scripts/book-check.sh target/release
set -eu
cd "$(dirname "$0")/.."
top=$PWD
page=docs/tutorial.md
PATH="$top/$1:$PATH"
export PATH
mkdir -p out/book-check
rm -rf out/book-check/out

# The lines of the page's blocks of kind $1
blocks() {
  awk -v kind="\`\`\`$1" '$0 == kind { inside = 1; next } /^```/ { inside = 0 } inside' "$page"
}

blocks sh > out/book-check/commands.sh
blocks text > out/book-check/said
[ -s out/book-check/commands.sh ] || { echo "$page: sh blocks: found none, expected the tutorial's commands" >&2; exit 1; }
(cd out/book-check && sh -eu commands.sh > printed 2> progress) || { cat out/book-check/progress >&2; exit 1; }

# A line that ends with ` …` is the beginning of a printed one
while read -r line; do
  begun=${line% …}
  awk -v line="$line" -v begun="$begun" '(line == begun && $0 == line) || (line != begun && index($0, begun) == 1) { found = 1 }
    END { exit !found }' out/book-check/printed out/book-check/progress \
    || { echo "$page: text block: found no such line printed, expected: $line; mend the page" >&2; exit 1; }
done < out/book-check/said

# The table of the design: a row per piece, with its seconds at 8 Hz
awk '/"sequence": \{/ { inside = 1 } /"statement":/ { inside = 0 }
  inside && /"maneuver":/ { gsub(/[",]/, ""); name = $2 }
  inside && name && /"samples":/ { gsub(/[",]/, ""); printf "| %s | %.1f s |\n", name, $2 / 8; name = "" }' \
  out/book-check/out/tutorial/results/design.json > out/book-check/rows
[ -s out/book-check/rows ] || { echo "design.json: sequence: found none, expected some; look at this script" >&2; exit 1; }
while read -r row; do
  grep -qxF "$row" "$page" || { echo "$page: table of the design: found no such row, expected: $row; mend the page" >&2; exit 1; }
done < out/book-check/rows

length=$(awk '/"accuracy": \{/ { inside = 1 } inside && /"duration_s":/ { gsub(/[",]/, ""); printf "%.1f s", $2; exit }' \
  out/book-check/out/tutorial/shortest.json)
grep -qF "$length" "$page" || { echo "$page: length of the trial: found no $length, expected it; mend the page" >&2; exit 1; }
echo "$page: commands run, numbers hold"
