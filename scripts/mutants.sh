#!/bin/sh
# How many faults do the tests of a crate see? Draws mutants of its source, runs its own tests on each, and tells how many they catch.
#
#   sh scripts/mutants.sh CRATE OUT [COUNT [SEED]]      CRATE: a folder of crates/; OUT: for the mutants that survive; 20 of seed 1
#
# Needs cargo-mutants: `cargo install cargo-mutants --locked`.
set -eu
[ $# -ge 2 ] || { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 2; }
cd "$(dirname "$0")/.."
[ -d "crates/$1" ] || { echo "mutants: found no crates/$1, expected a crate; name one" >&2; exit 2; }
cargo mutants --version > /dev/null 2>&1 || { echo "mutants: found no cargo-mutants; cargo install cargo-mutants --locked gets it" >&2; exit 2; }
package=$(sed -n 's/^name = "\(.*\)"/\1/p' "crates/$1/Cargo.toml" | head -n 1)
all=$(cargo mutants --package "$package" --list | wc -l)
parts=$(((all + ${3:-20} - 1) / ${3:-20}))
cargo mutants --package "$package" --shard "$((${4:-1} % parts))/$parts" --sharding round-robin --output "$2" --no-times -- --tests || true
found() { wc -l < "$2/mutants.out/$1.txt" | tr -d ' '; }
echo "$1, seed ${4:-1}: $(found caught "$2") caught, $(found missed "$2") survive, $(found timeout "$2") never end," \
  "$(found unviable "$2") do not compile"
