#!/bin/sh
# How much there is to know: a line per figure, its name and number. Fails where one is above its number in scripts/surface.most.
#
#   sh scripts/surface.sh [--static] [--build] [--program FILE] [--write]
#
# --static: without commands and flags, which the program `seatrial` in BIN tells (default: target/debug, or else target/release).
# --build: also CPU seconds of a clean release build. --program: also the size of a program in MB.
# --write: lowers the numbers in surface.most to what is found, adds those that it lacks, and raises none.
set -eu
# Letters are those of ASCII, wherever this runs
export LC_ALL=C
cd "$(dirname "$0")/.."
most=scripts/surface.most
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
static= build= program= write=
while [ $# -gt 0 ]; do
  case $1 in
    --static) static=yes ;;
    --build) build=yes ;;
    --write) write=yes ;;
    --program)
      program=${2:-}
      [ -f "$program" ] || { echo "surface: --program: found no file \`$program\`, expected a program; build it" >&2; exit 2; }
      shift ;;
    *) sed -n '2,8s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  esac
  shift
done

# Figure $1 is $2.
figure() {
  echo "$1 $2" | tee -a "$work/figures"
}

count() {
  wc -l | tr -d ' '
}

find crates/*/src -name '*.rs' | sort > "$work/files"
# The code: without comments, and without what stands in literals. A line stays a line.
# shellcheck disable=SC2046  # Many files.
awk '
  FNR == 1 { inside = ""; depth = 0 }
  {
    rest = $0; code = ""
    while (rest != "") {
      if (inside == "text") {
        if (!match(rest, /\\|"/)) break
        if (substr(rest, RSTART, 1) == "\\") { rest = substr(rest, RSTART + 2); continue }
        rest = substr(rest, RSTART + 1); inside = ""
      } else if (inside == "raw") {
        if (!(at = index(rest, ending))) break
        rest = substr(rest, at + length(ending)); inside = ""
      } else if (inside == "comment") {
        if (!match(rest, /\/\*|\*\//)) break
        depth += substr(rest, RSTART, 1) == "/" ? 1 : -1
        rest = substr(rest, RSTART + 2)
        if (!depth) inside = ""
      } else {
        if (!match(rest, /"|\047|\/\/|\/\*/)) { code = code rest; break }
        mark = substr(rest, RSTART, RLENGTH); before = substr(rest, 1, RSTART - 1)
        rest = substr(rest, RSTART + RLENGTH); code = code before
        if (mark == "//") break
        if (mark == "/*") { inside = "comment"; depth = 1 }
        else if (mark == "\"") {
          inside = "text"; code = code " "
          if (before ~ /(^|[^A-Za-z0-9_])b?r#*$/) { sub(/^.*r/, "", before); ending = "\"" before; inside = "raw" }
        }
        # A character, or else a lifetime
        else if (substr(rest, 1, 1) == "\\") { rest = substr(rest, 3); rest = substr(rest, index(rest, "\047") + 1) }
        else if (match(rest, /^[^\047]+\047/) && (RLENGTH == 2 || substr(rest, 1, 1) !~ /[A-Za-z_ ]/)) rest = substr(rest, RLENGTH + 1)
        else code = code "\047"
      }
    }
    print code
  }' $(cat "$work/files") > "$work/code"

figure json-documents "$(find schemas -name '*.schema.json' ! -name '*-toml.schema.json' | count)"
# Where a kind of table gets its columns, above the tests of a file: `Columns::new(ID, …)` or `TableSchema { id: "…", … }`
# shellcheck disable=SC2046
figure tables "$(awk '
  FNR == 1 { tests = 0 }
  /^#\[cfg\(test\)\]/ { tests = 1 }
  !tests && !/^ *\/\// && match($0, /(Columns(::<[A-Za-z]+>)?::new\(|TableSchema \{ id: )("[a-z]|[A-Z])/) {
    name = substr($0, RSTART + RLENGTH - 1); sub(/[,)}].*/, "", name); print FILENAME, name
  }' $(cat "$work/files") | sort -u | count)"
# The kinds that have a schema, and those that only a flag names. What may be written instead of a document, as
# `available.toml|ingest.json`, is not one.
# shellcheck disable=SC2046
figure kinds "$({
  find schemas -name '*-toml.schema.json' | sed 's#.*/\(.*\)-toml.schema.json#\1.toml#'
  awk 'match($0, /value_name = "[a-z]+\.toml"/) { split(substr($0, RSTART, RLENGTH), part, "\""); print part[2] }' $(cat "$work/files")
} | sort -u | count)"

# Commands that can be run, by the help of each. What each command takes (--help, --version, --out and the flags of the program
# itself) and second names of flags are not counted.
bin=${BIN:-target/debug}
[ -n "${BIN:-}" ] || [ -x "$bin/seatrial" ] || bin=target/release
if [ -n "$static" ]; then
  :
elif [ ! -x "$bin/seatrial" ]; then
  echo "surface: commands and flags are not counted: found no $bin/seatrial; build it, or name its folder with BIN=" >&2
else
  echo > "$work/open"
  : > "$work/told"
  while read -r words; do
    # Flags of the program itself are in its long help alone.
    if [ -n "$words" ]; then long=-h; else long=--help; fi
    # shellcheck disable=SC2086  # Several words.
    "$bin/seatrial" $words $long > "$work/help"
    awk -v words="$words" '
      /^Usage: / { print / <COMMAND>$/ ? "group" : "command", words }
      /^[^ ]/ { commands = $0 == "Commands:" }
      commands && /^  [a-z]/ && $1 != "help" { print "sub", (words == "" ? "" : words " ") $1 }
      /^  (-[A-Za-z], |    )--[a-z]/ {
        sub(/^ +(-[A-Za-z], )?--/, ""); sub(/[^a-z0-9-].*/, "")
        print words == "" ? "of-all" : "flag", $0, words
      }' "$work/help" > "$work/one"
    sed -n 's/^sub //p' "$work/one" >> "$work/open"
    cat "$work/one" >> "$work/told"
  done < "$work/open"
  figure commands "$(grep -c '^command ' "$work/told")"
  awk '
    $1 == "of-all" { all[$2] = 1 }
    $1 == "flag" && $2 != "out" && !($2 in all) { print $2 }' "$work/told" > "$work/pairs"
  sort -u "$work/pairs" > "$work/flags"
  figure flags "$(count < "$work/flags")"
  figure pairs "$(count < "$work/pairs")"
  # Flags that no Makefile, pipeline, script or page has; keys of study.toml are flags, too
  { echo Makefile README.md docs/*.md; find pipelines scripts -type f ! -name 'surface.*'; } | tr ' ' '\n' > "$work/places"
  # shellcheck disable=SC2046
  figure unused-flags "$(awk -v flags="$work/flags" '
    BEGIN { while ((getline name < flags) > 0) left[name] = 1 }
    FILENAME ~ /study.toml$/ && match($0, /^[a-z_]+ = /) {
      name = substr($0, 1, RLENGTH - 3); gsub("_", "-", name); delete left[name]
    }
    { while (match($0, /--[a-z][a-z0-9-]*/)) { delete left[substr($0, RSTART + 2, RLENGTH - 2)]; $0 = substr($0, RSTART + RLENGTH) } }
    END { for (name in left) print name }' $(cat "$work/places") | count)"
fi

# Not the one that only names features
figure crates "$(ls -d crates/*/Cargo.toml | grep -cv '/workspace-hack/')"
figure files "$(count < "$work/files")"
# Declarations of struct, enum, trait and type, those of `choices!` and types that belong to an implementation among them
sed -n -E 's/^[ \t]*(pub(\([a-z ]*\))? )?(struct|enum|trait|type) ([A-Z][A-Za-z0-9]*).*/\3 \4/p' "$work/code" > "$work/types"
figure types "$(count < "$work/types")"
# Not of those that belong to an implementation, which each call theirs `Output`
figure repeated-types "$(sed -n -E 's/^([ \t]*(pub(\([a-z ]*\))? )?(struct|enum|trait)|(pub(\([a-z ]*\))? )?type) ([A-Z][A-Za-z0-9]*).*/\7/p' \
  "$work/code" | sort | uniq -c | awk '$1 > 3' | count)"
# Comments and tests are lines, too
figure lines "$(count < "$work/code")"
figure packages "$(grep -c '^\[\[package\]\]' Cargo.lock)"
# Every use of the identifier `own`
figure own "$(awk '{ n = split($0, words, /[^A-Za-z0-9_]+/); for (i = 1; i <= n; i++) found += words[i] == "own" } END { print found + 0 }' \
  "$work/code")"
# Every function and value that is called `found`; not a parameter with a type, which is what a refusal found
figure found "$(awk '
  { $0 = " " $0 " "
    sum += gsub(/[^A-Za-z0-9_](let|let mut|fn|for) found[^A-Za-z0-9_]/, "&")
    sum += gsub(/\|&?found\|/, "&") + gsub(/[^A-Za-z0-9_]let (Some|Ok|Err)\(found\)/, "&") }
  END { print sum + 0 }' "$work/code")"
figure pages "$(find docs -name '*.md' | count)"
figure page-lines "$(cat docs/*.md | count)"
figure architecture-bytes "$(wc -c < ARCHITECTURE.md | tr -d ' ')"

if [ -n "$build" ]; then
  CARGO_INCREMENTAL=0 CARGO_TARGET_DIR="$work/target" sh -c \
    '"${CARGO:-cargo}" build --release --locked --workspace --bins >&2 && times' > "$work/times"
  # The second line is that of the build: minutes and seconds as user, and in the system
  figure build-cpu-s "$(awk -F '[ms ]+' 'NR == 2 { printf "%.0f\n", 60 * ($1 + $3) + $2 + $4 }' "$work/times")"
fi
if [ -n "$program" ]; then
  figure program-mb "$(wc -c < "$program" | awk '{ printf "%.1f\n", $1 / 1e6 }')"
fi

if [ -n "$write" ]; then
  {
    echo "# The most that scripts/surface.sh may find of each figure. Numbers only fall: delete before you add."
    echo "# \`sh scripts/surface.sh --write\` lowers them to what is found; a test compares them with those of the commit before."
    awk '
      FILENAME == ARGV[1] { found[$1] = $2; names[++n] = $1; next }
      /^#/ { next }
      { most[$1] = $2; print $1, $1 in found && found[$1] < $2 ? found[$1] : $2 }
      END { for (i = 1; i <= n; i++) if (!(names[i] in most)) print names[i], found[names[i]] }' "$work/figures" \
      "$([ -f $most ] && echo $most || echo /dev/null)"
  } > "$work/most"
  cp "$work/most" $most
fi
[ -f $most ] || { echo "surface: $most: found no such file, expected it; sh scripts/surface.sh --write" >&2; exit 1; }
awk -v most=$most '
  FILENAME == ARGV[1] { if (!/^#/) at_most[$1] = $2; next }
  $1 in at_most && $2 > at_most[$1] {
    printf "surface: %s: found %s, expected at most %s; delete before you add, %s\n", $1, $2, at_most[$1], most; above = 1
  }
  END { exit above }' $most "$work/figures" >&2
