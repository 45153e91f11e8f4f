#!/bin/sh
# Do two revisions write the same bytes? Builds both, runs the small studies with both, compares the SHA-256 of every output.
#
#   sh scripts/same-bytes.sh BASE HEAD                     two revisions, each built for release in a work tree of its own
#   sh scripts/same-bytes.sh --run TREE BIN OUT [STUDY...] the small studies (all, or those named) with the program `seatrial`
#                                                          in BIN, which TREE built; ends with OUT/digests
#   sh scripts/same-bytes.sh --compare OUT OUT             two such folders
#
# The studies of measured logs take part where their logs are: in the folders that ESSO_OSAKA_LOGS and KVLCC2_LOGS name, or else
# in ../shared/data.
#
# A difference that is meant stands in scripts/same-bytes.meant: a pattern of paths (as the shell's case has them), a tab and
# the reason. Whatever differs and matches none makes this fail, and so does a pattern that nothing needs.
set -eu
STUDIES="smoke paper helsinki model-ship pooled sequential white current-constant current-gauss-markov wind-bias generated
esso-osaka kvlcc2"
here=$(cd "$(dirname "$0")" && pwd)
# A few recordings of each kind; of KVLCC2 all 13, which are short.
ESSO_OSAKA="random/random_31-Jul-2020_14_52_18 turning/turn_14-Oct-2020_14_39_54 turning/turn_14-Sep-2020_13_51_45
zigzag/zigzag_31-Jul-2020_13_14_21 zigzag/zigzag_31-Jul-2020_13_50_28 zigzag/zigzag_31-Jul-2020_14_03_39
berthing/berthing_12-Nov-2020_11_14_47"

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
    esso-osaka | kvlcc2)
      # A tree of before study.toml has study.mk
      if [ -f "$3/study.mk" ]; then
        sed -i -e 's/^BOOTSTRAP .*/BOOTSTRAP = 5/' -e 's/--compact/--compact --bootstrap 2/' -e 's/--duration-s 1800/--duration-s 600/' \
          -e 's/^TEST \(.*\)= *random.*/TEST = turn_14-Sep-2020_13_51_45/' "$3/study.mk"
      else
        sed -i -e 's/^bootstrap = .*/bootstrap = 5/' -e '/^\[search\]/,$ s/^window_s = 100/window_s = 100\nbootstrap = 2/' \
          -e 's/^duration_s = 1800/duration_s = 600/' -e '/^    "[rtz]/{/turn_14-Sep/!d}' "$3/study.toml"
      fi
      sed -i -e 's/^realizations = .*/realizations = 4/' -e 's/^duration_s = 1800.0/duration_s = 600.0/' \
        -e 's/^segments = .*/segments = 5/' "$3/next/campaign.toml"
      sed -i -e 's/^informative_s = 1800.0/informative_s = 600.0/' -e 's/^runs = .*/runs = 24/' "$3/next/plan.toml" ;;
  esac
  case $1 in
    esso-osaka)
      sed -i 's/^candidates = [0-9]*/candidates = 40/' "$3/next/dictionary.toml" ;;
  esac
}

# The folder with the logs of study $1: as its variable says, else that of ../shared/data if there is one.
logs() {
  case $1 in
    esso-osaka) variable=ESSO_OSAKA_LOGS given=${ESSO_OSAKA_LOGS:-} usual=$here/../../shared/data/esso_osaka ;;
    *) variable=KVLCC2_LOGS given=${KVLCC2_LOGS:-} usual=$here/../../shared/data/kvlcc2_hsva ;;
  esac
  if [ -n "$given" ] && [ ! -d "$given" ]; then
    echo "same-bytes: $variable: found no folder \`$given\`, expected that of the logs; correct or unset it" >&2
    return 1
  fi
  folder=${given:-$usual}
  [ ! -d "$folder" ] || (cd "$folder" && pwd)
}

# The few logs of study $1, from the folder $2 into the folder $3.
few() {
  case $1 in
    esso-osaka) names=$ESSO_OSAKA ;;
    *) names=$(cd "$2" && ls kvlcc2_hsva_Z_*.csv | sed 's/\.csv$//') ;;
  esac
  for log in $names; do
    mkdir -p "$(dirname "$3/$log")"
    cp "$2/$log.csv" "$3/$log.csv"
  done
}

# Study $1 of tree $2 with the program in $3, its logs in $4 if it has any; in a folder that stands for the tree, by relative paths,
# so that no path of this machine is in any output.
study() {
  out=../$1 copy=pipelines/$1 program=$3/seatrial
  case $1 in
    sequential)
      small sequential "$2" "$copy"
      mkdir -p "$out"
      # A tree of before [rounds] has sequential.toml
      if [ -f "$copy/sequential.toml" ]; then stage=sequential more="--config $copy/sequential.toml"; else stage=monte-carlo more=; fi
      "$program" $stage --quiet --vessel "$copy/vessel.toml" --dictionary "$copy/dictionary.toml" \
        --campaign "$copy/campaign.toml" $more --out "$out/sequential.parquet"
      "$program" report --quiet --study "$copy" --results "$out" --out "$out/report.html" ;;
    white | current-constant | current-gauss-markov | wind-bias)
      small "scenarios/$1" "$2" "$copy"
      mkdir -p pipelines/scenarios
      cp "$2/pipelines/scenarios/dictionary.toml" pipelines/scenarios/
      "$program" run "$copy" --out "$out" --quiet ;;
    model-ship)
      small model-ship "$2" "$copy"
      few=--setting=BOOTSTRAP=20
      [ -f "$copy/study.mk" ] || few=--set=study.estimate.bootstrap=20
      "$program" run "$copy" $few --out "$out" --quiet ;;
    esso-osaka | kvlcc2)
      small "$1" "$2" "$copy"
      few "$1" "$4" "logs/$1"
      "$program" run "$copy" --logs "logs/$1" --out "$out" --quiet ;;
    pooled)
      small smoke "$2" "$copy"
      "$program" run "$copy" --stage campaign --out "$out" --quiet
      for estimator in ls iv output-error; do
        mkdir -p "$out/$estimator"
        "$program" estimate --fit together --quiet --estimator $estimator --bootstrap 20 --vessel "$copy/vessel.toml" \
          --trajectories "$out/campaign.parquet" --runs optimized/0,optimized/1,random/2 --out "$out/$estimator/"
      done
      "$program" estimate --fit together --folds each --estimator ls,iv,auto,output-error --quiet --vessel "$copy/vessel.toml" --trajectories "$out/campaign.parquet" \
        --runs optimized/0,optimized/1,random/2 --out "$out/scores.json" ;;
    *)
      small "$1" "$2" "$copy"
      "$program" run "$copy" --out "$out" --quiet ;;
  esac
}

run() {
  tree=$(cd "$1" && pwd) bin=$(cd "$2" && pwd) to=$3
  shift 3
  [ $# -gt 0 ] || set -- $STUDIES
  [ -x "$bin/seatrial" ] || { echo "same-bytes: found no $bin/seatrial, expected the program; build it" >&2; exit 1; }
  rm -rf "$to"
  mkdir -p "$to"
  to=$(cd "$to" && pwd)
  mkdir -p "$to/.tree"
  ln -s "$tree/fixtures" "$to/.tree/fixtures"
  for name in "$@"; do
    folder=
    case $name in
      esso-osaka | kvlcc2)
        folder=$(logs "$name")
        if [ -z "$folder" ]; then
          echo "$name: skipped: found no folder of its logs; name it with ESSO_OSAKA_LOGS or KVLCC2_LOGS"
          continue
        fi ;;
    esac
    echo "$name"
    # In the background, since the shell would go on after a failure within a list of ||
    (cd "$to/.tree" && study "$name" "$tree" "$bin" "$folder") > "$to/$name.log" 2>&1 &
    wait $! || { cat "$to/$name.log" >&2; exit 1; }
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
  '' | -*) sed -n '2,13s/^# \{0,1\}//p' "$0" >&2; exit 2 ;;
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
