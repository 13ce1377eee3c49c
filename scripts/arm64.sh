#!/usr/bin/env bash
# Cross-compiles for AArch64, runs tests there and compares with this machine, all under qemu-user:
#   scripts/arm64.sh [--short]
# The same bits of the C library's functions, the same kernels, and the same messages of two
# scenarios flown to their end by either build (--short: 2 s of flight). Needs the x86 build of the
# release preset, and `npm ci --prefix tests/npm`.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1

form=whole
case ${1:-} in
  "") ;;
  --short) form=short ;;
  *) echo "arm64.sh: argument = $1, expected --short or none" >&2; exit 2 ;;
esac
x86=build/release arm=build/arm64 out=out/arm64
layers=(base formula model potential)

. scripts/stages.sh

scripts/deps.sh arm64 || refuse "packages for AArch64 are missing and could not be installed, expected those of scripts/deps.sh arm64"
for program in aarch64-linux-gnu-g++ qemu-aarch64 node; do
  command -v "$program" >/dev/null || refuse "$program is missing, expected that of scripts/deps.sh arm64"
done
[[ -d tests/npm/node_modules ]] || npm ci --prefix tests/npm --no-audit --no-fund >&2 || refuse "the reader of logs is missing, expected npm ci --prefix tests/npm to pass"
[[ -x $x86/bin/sightline ]] || refuse "$x86/bin/sightline is missing, expected a build of the release preset"
mkdir -p "$out"

build() { cmake --preset arm64 >"$out/configure.txt" && cmake --build --preset arm64 --target sightline_cli "${layers[@]/%/_test}"; }
# Functions of the C library over many arguments, a hash each.
c_library() {
  local -a flags=(-std=c++20 -O1 -ffp-contract=off -fno-builtin tests/support/c_library_bits.cpp)
  g++ "${flags[@]}" -o "$out/bits_x86" && aarch64-linux-gnu-g++ "${flags[@]}" -o "$out/bits_arm" || return 1
  diff <("$out/bits_x86") <(qemu-aarch64 "$out/bits_arm")
}
kernels() { diff -rq $x86/generated/kernels $arm/generated/kernels; }
tests() {
  local bad=0
  for layer in "${layers[@]}"; do
    qemu-aarch64 "$arm/tests/${layer}_test" --gtest_brief=1 || bad=1
  done
  return "$bad"
}
flight() {
  local scenario=$out/$1.toml side
  cp "scenarios/$1.toml" "$scenario"
  if [[ $form == short ]]; then
    awk '/^\[/ { inside = $0 ~ /^\[simulation\]/ } inside && /^duration *=/ { $0 = "duration = 2.0" } { print }' "scenarios/$1.toml" >"$scenario"
  fi
  for side in x86 arm; do
    local -a run=("${!side}/bin/sightline")
    [[ $side == x86 ]] || run=(qemu-aarch64 "${run[@]}")
    "${run[@]}" run "$scenario" --seed 1 -o "$out/$side/$1" >"$out/$side-$1.txt" 2>&1
    (($? <= 1)) || { echo "$side: $1 did not fly"; tail -n 3 "$out/$side-$1.txt"; return 1; }
  done
  local log bad=0
  while read -r log; do  # of the comparisons too
    printf '%s: ' "$log" && node tests/npm/same_mcap.mjs "$out/x86/$1/$log" "$out/arm/$1/$log" || bad=1
  done < <(cd "$out/x86/$1" && find . -name run.mcap | sort)
  return "$bad"
}

stage "build" build || finish
stage "functions of the C library" c_library
stage "kernels" kernels
stage "tests" tests
for name in paper_7_1 cooperative_localization; do stage "$name" flight "$name"; done
finish
