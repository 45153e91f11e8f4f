#!/bin/sh
# Do the programs give the same on another system? Builds them here for Windows (x86-64) or for Linux on ARM (64 bits), runs their
# tests and a few studies by wine or qemu, and compares every file with what this machine gives. Processors of x86-64 that have no
# AVX-512 (2013) or neither AVX2 nor FMA (2008) are emulated with the release program.
#
#   sh scripts/other-systems.sh windows|arm64|2013|2008 OUT [STUDY...]      OUT: a folder for programs and outputs
#
# TESTS are the packages that are tested, such as "-p seatrial-ship": all but that of the command line unless it is set, `TESTS=`
# for none. WHEEL=yes builds the wheel, too. Needs Debian as root, which gives compilers and emulators, and a nightly cargo, which
# builds the standard library from Debian's sources.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
top=$(cd "$here/.." && pwd)
kind=${1:-}
[ $# -ge 2 ] || { sed -n '2,11s/^# \{0,1\}//p' "$0" >&2; exit 2; }
mkdir -p "$2"
out=$(cd "$2" && pwd)
shift 2
[ $# -gt 0 ] || set -- smoke paper pooled helsinki esso-osaka
TESTS=${TESTS---workspace --exclude seatrial-cli}

# Packages $1 of Debian, unless the program $2 is there.
have() {
  command -v "$2" > /dev/null || [ -x "$2" ] && return
  # shellcheck disable=SC2086 # words
  apt-get install -y -qq $1 > /dev/null || { echo "other-systems: found no $2, expected Debian's $1; install it" >&2; exit 2; }
}

# The program `seatrial` in the folder $1, by the words before it.
wrap() {
  mkdir -p "$1"
  printf '#!/bin/sh\nexec %s "$@"\n' "$2" > "$1/seatrial"
  chmod +x "$1/seatrial"
}

built() {
  have "rustc-web rust-web-src" /usr/bin/rustc
  RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR="$out/target" CARGO_INCREMENTAL=0 \
    cargo +nightly "$@" -Zbuild-std=std,panic_unwind --target "$target" --locked
}

native=$top/target/debug target=
case $kind in
  windows)
    target=x86_64-pc-windows-gnu
    have "mingw-w64" x86_64-w64-mingw32-gcc
    have "wine64" /usr/lib/wine/wine64
    export WINEPREFIX="$out/wine" WINEDEBUG=-all
    # The library asks for random bytes by a function that this wine does not have.
    folder=$out/target/$target/debug
    mkdir -p "$folder/deps" "$folder/examples"
    cat > "$out/random.c" <<'C'
#include <windows.h>
BOOLEAN NTAPI SystemFunction036(PVOID, ULONG);
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T size) { return SystemFunction036(data, (ULONG)size); }
C
    x86_64-w64-mingw32-gcc -shared -O1 -o "$out/bcryptprimitives.dll" "$out/random.c" -ladvapi32
    for place in . deps examples; do cp "$out/bcryptprimitives.dll" "$folder/$place/"; done
    export CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER=/usr/lib/wine/wine64
    wrap "$out/programs" "/usr/lib/wine/wine64 '$folder/seatrial.exe'" ;;
  arm64)
    target=aarch64-unknown-linux-gnu
    have "gcc-aarch64-linux-gnu g++-aarch64-linux-gnu" aarch64-linux-gnu-gcc
    have qemu-user qemu-aarch64
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L /usr/aarch64-linux-gnu"
    wrap "$out/programs" "qemu-aarch64 -L /usr/aarch64-linux-gnu '$out/target/$target/debug/seatrial'" ;;
  2013 | 2008)
    [ "$(uname -m)" = x86_64 ] || { echo "other-systems: found $(uname -m), expected x86_64; try it there" >&2; exit 2; }
    have qemu-user qemu-x86_64
    native=$top/target/release TESTS=
    wrap "$out/programs" "qemu-x86_64 -cpu $([ "$kind" = 2013 ] && echo Haswell || echo Nehalem) '$native/seatrial'" ;;
  *) echo "other-systems: found \`$kind\`, expected windows, arm64, 2013 or 2008; name one" >&2; exit 2 ;;
esac
[ -z "$target" ] || built build -p seatrial-cli --bin seatrial
[ -x "$native/seatrial" ] || { echo "other-systems: found no $native/seatrial, expected the program; build it" >&2; exit 2; }

# shellcheck disable=SC2086 # words
[ -z "$TESTS" ] || built test $TESTS --tests --no-fail-fast
if [ -n "${WHEEL:-}" ] && [ -n "$target" ]; then
  [ -x "$out/wheel/bin/maturin" ] || { python3 -m venv "$out/wheel" && "$out/wheel/bin/pip" install --quiet "maturin>=1.9,<2"; }
  (cd "$top/python" && RUSTUP_TOOLCHAIN=nightly RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 CARGO_TARGET_DIR="$out/target" \
    "$out/wheel/bin/maturin" build --release -Zbuild-std=std,panic_unwind --target "$target" --out "$out/wheels")
fi
sh "$here/same-bytes.sh" --run "$top" "$native" "$out/native" "$@"
sh "$here/same-bytes.sh" --run "$top" "$out/programs" "$out/other" "$@"
if cmp -s "$out/native/digests" "$out/other/digests"; then
  echo "other-systems: $kind: $(wc -l < "$out/native/digests") files, all the same"
else
  echo "other-systems: $kind: these of $(wc -l < "$out/native/digests") files differ:"
  # shellcheck disable=SC2046 # paths without spaces
  python3 "$here/near.py" "$out/native" "$out/other" $(diff "$out/native/digests" "$out/other/digests" | sed -n 's/^> [0-9a-f]* *//p')
fi
