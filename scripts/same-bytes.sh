#!/bin/sh
# Do two revisions write the same bytes? Builds both, runs the small studies with both, compares the SHA-256 of every output.
#
#   sh scripts/same-bytes.sh BASE HEAD                     two revisions, each built for release in a work tree of its own
#   sh scripts/same-bytes.sh --run TREE BIN OUT [STUDY...] the small studies (all, or those named) with the programs in BIN,
#                                                          which TREE built; ends with OUT/digests
#   sh scripts/same-bytes.sh --compare OUT OUT             two such folders
#
# A difference that is meant stands in scripts/same-bytes.meant: a pattern of paths (as the shell's case has them), a tab and
# the reason. Whatever differs and matches none makes this fail, and so does a pattern that nothing needs.
set -eu
STUDIES="smoke paper helsinki model-ship pooled sequential white current-constant current-gauss-markov wind-bias generated"
here=$(cd "$(dirname "$0")" && pwd)

# A copy of study $1 of tree $2 in $3, small.
small() {
  mkdir -p "$3"
  cp -r "$2/pipelines/$1/." "$3/"
  case $1 in
    paper) of=100 ;;
    sequential | scenarios/*) of=8 ;;
    *) of= ;;
  esac
  if [ -n "$of" ]; then
    for file in campaign.toml sequential.toml; do
      [ ! -f "$3/$file" ] || sed -i "s/^realizations = .*/realizations = $of/" "$3/$file"
    done
  fi
  case $1 in
    helsinki) sed -i 's/^realizations = .*/realizations = 20/' "$3/campaign.toml" ;;
    generated)
      sed -i 's/^candidates = [0-9]*/candidates = 100/' "$3/dictionary.toml"
      sed -i 's/^realizations = .*/realizations = 8/' "$3/campaign.toml" ;;
  esac
}

# Study $1 of tree $2 with the programs in $3, its outputs in $4.
study() {
  out=$4/$1
  copy=$4/.tree/pipelines/$1
  make="make --no-print-directory -C $2 CARGO=true BIN=$3 FLAGS=--quiet OUT=$out"
  case $1 in
    sequential)
      small sequential "$2" "$copy"
      mkdir -p "$out"
      "$3/sequential" --quiet --vessel "$copy/vessel.toml" --dictionary "$copy/dictionary.toml" \
        --campaign "$copy/campaign.toml" --config "$copy/sequential.toml" --out "$out/sequential.parquet"
      "$3/report" --quiet --study "$copy" --results "$out" --out "$out/report.html" ;;
    white | current-constant | current-gauss-markov | wind-bias)
      small "scenarios/$1" "$2" "$copy"
      $make STUDY="$copy" study ;;
    model-ship)
      small model-ship "$2" "$copy"
      "$3/seatrial" run "$copy" --setting BOOTSTRAP=20 --out "$out" --quiet ;;
    pooled)
      small smoke "$2" "$copy"
      "$3/seatrial" run "$copy" --stage campaign --out "$out" --quiet
      for estimator in ls iv output-error; do
        mkdir -p "$out/$estimator"
        "$3/estimate" pool --help > /dev/null 2>&1 && pool=pool || pool=--pool
        "$3/estimate" $pool --quiet --estimator $estimator --bootstrap 20 --vessel "$copy/vessel.toml" \
          --trajectories "$out/campaign.parquet" --runs optimized/0,optimized/1,random/2 --out "$out/$estimator/"
      done
      "$3/validate" cross --quiet --vessel "$copy/vessel.toml" --trajectories "$out/campaign.parquet" \
        --runs optimized/0,optimized/1,random/2 --estimators ls,iv,output-error --out "$out/crossval.json" ;;
    *)
      small "$1" "$2" "$copy"
      $make STUDY="$copy" study ;;
  esac
}

run() {
  tree=$(cd "$1" && pwd) bin=$(cd "$2" && pwd) to=$3
  shift 3
  [ $# -gt 0 ] || set -- $STUDIES
  rm -rf "$to"
  mkdir -p "$to"
  to=$(cd "$to" && pwd)
  mkdir -p "$to/.tree"
  ln -s "$tree/fixtures" "$to/.tree/fixtures"
  for name in "$@"; do
    echo "$name"
    study "$name" "$tree" "$bin" "$to" > "$to/$name.log" 2>&1 || { cat "$to/$name.log" >&2; exit 1; }
    rm "$to/$name.log"
  done
  rm -rf "$to/.tree"
  (cd "$to" && find . -type f ! -path ./digests ! -name run.json | sed 's#^\./##' | LC_ALL=C sort | xargs sha256sum) > "$to/digests"
}

compare() {
  meant=$here/same-bytes.meant
  tab=$(printf '\t')
  differ=$(cat "$1/digests" "$2/digests" | LC_ALL=C sort | uniq -u | awk '{ print $2 }' | LC_ALL=C sort -u)
  unmeant= needed=
  for path in $differ; do
    found=
    while IFS="$tab" read -r pattern reason; do
      case $pattern in '' | '#'*) continue ;; esac
      case $path in $pattern) found=$pattern; break ;; esac
    done < "$meant"
    if [ -n "$found" ]; then needed="$needed $found"; else unmeant="$unmeant $path"; fi
  done
  files=$(wc -l < "$2/digests")
  for path in $unmeant; do echo "differs: $path" >&2; done
  [ -z "$unmeant" ] || { echo "same-bytes: found files that differ and that same-bytes.meant does not name" >&2; exit 1; }
  if [ -n "${STRICT:-}" ]; then
    while IFS="$tab" read -r pattern reason; do
      case $pattern in '' | '#'*) continue ;; esac
      case " $needed " in *" $pattern "*) ;; *) echo "same-bytes.meant: found $pattern, which nothing needs; remove it" >&2; exit 1 ;; esac
    done < "$meant"
  fi
  echo "same-bytes: $files files, $(printf '%s\n' "$differ" | grep -c . || true) differ as meant, the others are the same"
}

case ${1:-} in
  --run) shift; run "$@" ;;
  --compare) compare "$2" "$3" ;;
  '' | -*) sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
  *)
    work=$(mktemp -d)
    trap 'git worktree remove --force "$work/base" 2> /dev/null; git worktree remove --force "$work/head" 2> /dev/null; rm -rf "$work"' EXIT
    for side in base head; do
      [ $side = base ] && revision=$1 || revision=$2
      git worktree add --quiet --detach "$work/$side" "$revision"
      (cd "$work/$side" && cargo build --quiet --release --locked --workspace --bins)
      run "$work/$side" "$work/$side/target/release" "$work/$side-out"
    done
    STRICT=1 compare "$work/base-out" "$work/head-out" ;;
esac
