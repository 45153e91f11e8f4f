#!/bin/sh
# Do the programs write the same bytes on a processor without AVX-512? Runs small studies with the programs in BIN as they
# are and under an emulated processor of 2013, with AVX2 and no AVX-512, and compares the SHA-256 of every output.
#
#   sh scripts/same-bits.sh BIN OUT [STUDY...]      BIN: a folder of release programs; OUT: for the outputs
#
# Emulation needs qemu-x86_64 (Debian: qemu-user) and takes about twenty times as long. Without it, or on another kind of
# processor, nothing is compared.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "$1" && pwd)
mkdir -p "$2"
out=$(cd "$2" && pwd)
shift 2
[ $# -gt 0 ] || set -- smoke paper pooled helsinki
if [ "$(uname -m)" != x86_64 ] || ! command -v qemu-x86_64 > /dev/null; then
  echo "same-bits: skipped: needs an x86-64 processor and qemu-x86_64 (Debian: qemu-user)"
  exit 0
fi
mkdir -p "$out/programs"
for program in "$bin"/*; do
  if [ -f "$program" ] && [ -x "$program" ]; then
    printf '#!/bin/sh\nexec qemu-x86_64 -cpu Haswell "%s" "$@"\n' "$program" > "$out/programs/${program##*/}"
    chmod +x "$out/programs/${program##*/}"
  fi
done
sh "$here/same-bytes.sh" --run "$here/.." "$bin" "$out/native" "$@"
sh "$here/same-bytes.sh" --run "$here/.." "$out/programs" "$out/emulated" "$@"
if cmp -s "$out/native/digests" "$out/emulated/digests"; then
  echo "same-bits: $(wc -l < "$out/native/digests") files, all the same"
else
  echo "same-bits: these differ:"
  diff "$out/native/digests" "$out/emulated/digests" | sed -n 's/^> [0-9a-f]* *//p'
  exit 1
fi
