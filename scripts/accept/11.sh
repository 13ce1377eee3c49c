#!/usr/bin/env bash
# Every figure that "Ready for the world" asks for, section by section:  scripts/accept/11.sh [--short] [SECTION ...]
# What is finished stays in out/accept/11/ and is not done again; delete it to begin anew. Needs the release preset, and
# `npm ci --prefix tests/npm`. BEFORE=path names the binary of the commit before, which flies the scenarios of its time.
# --short is for CI: a log against itself.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
begin_commit=22aaa23  # the last one before
build=build/release
. scripts/accept/sections.sh
whole || begin_commit=HEAD BEFORE=$build/bin/sightline

# What a binary understands of a scenario; warnings are words about it.
team_of() { "$1" check "$2" 2>/dev/null | grep -v '^warning'; }

# The log of every shipped scenario, seed 1, is the same before and after, message by message. "Record a formula in one
# way" changed last bits: what came before it is compared up to its parent, what came after from it.
logs() {
  local before=${BEFORE:-} after=$build/bin/sightline name told bad=0 flown=0
  [[ -x $before ]] || { echo "BEFORE = \"$before\", expected the binary of the commit before"; return 1; }
  local -a scenarios=(scenarios/*.toml)
  whole || scenarios=(scenarios/handover.toml)
  mkdir -p "$out/tree"
  git archive "$begin_commit" scenarios | tar -x -C "$out/tree" || return 1
  for scenario in "${scenarios[@]}"; do
    name=$(basename "$scenario" .toml)
    [[ -f $out/tree/$scenario ]] || continue  # it is new
    if told=$(diff <(team_of "$before" "$out/tree/$scenario") <(team_of "$after" "$scenario")); [[ -n $told ]]; then
      printf '%-40s is another team now:\n%s\n' "$scenario" "$told"
      continue
    fi
    for side in before after; do
      local of=$scenario
      [[ $side == after ]] || of=$out/tree/$scenario
      "${!side}" run "$of" --seed 1 -o "$out/$side/$name" >"$out/$side-$name.txt" 2>&1
      (($? <= 1)) || { echo "$side: $scenario did not fly"; tail -n 3 "$out/$side-$name.txt"; bad=$((bad + 1)); continue 2; }
    done
    if told=$(node tests/npm/same_mcap.mjs "$out"/{before,after}/"$name"/run.mcap 2>&1); then
      flown=$((flown + 1))
    else
      bad=$((bad + 1))
    fi
    printf '%-40s %s\n' "$scenario" "$told"
    rm -rf "$out"/{before,after}/"$name" "$out"/{before,after}-"$name.txt"
  done
  echo "$flown logs the same, $bad not"
  ((bad == 0 && flown > 0))
}

# Every shipped scenario, flown with seed 1 and then replayed: no command differs, and in how many seconds.
replay() {
  local name begin seconds bad=0 flown=0
  local -a scenarios=(scenarios/*.toml)
  whole || scenarios=(scenarios/handover.toml)
  for scenario in "${scenarios[@]}"; do
    name=$(basename "$scenario" .toml)
    "$build/bin/sightline" run "$scenario" --seed 1 -o "$out/$name" >"$out/$name.txt" 2>&1
    (($? <= 1)) || { echo "$scenario did not fly"; tail -n 3 "$out/$name.txt"; bad=$((bad + 1)); continue; }
    begin=$EPOCHREALTIME
    if "$build/bin/sightline" replay "$out/$name" >"$out/$name.txt" 2>&1; then flown=$((flown + 1)); else bad=$((bad + 1)); fi
    seconds=$(awk -v a="$begin" -v b="$EPOCHREALTIME" 'BEGIN { printf "%.2f", b - a }')
    printf '%6s s  %s\n' "$seconds" "$(tail -n 1 "$out/$name.txt")"
    rm -rf "${out:?}/$name" "$out/$name.txt"
  done
  echo "$flown replayed, $bad not"
  ((bad == 0 && flown > 0))
}

# What others get: components without what they do not need, old processors, shared libraries, an older compiler.
package() {
  local work name told
  local -a without=()
  work=$(mktemp -d) || return 1
  for name in SQLite3 tomlplusplus nlohmann_json CLI11 ZLIB PkgConfig; do
    without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$name=ON")
  done
  told=$(cmake -S . -B "$work/core" -G Ninja "${without[@]}" 2>&1) || { echo "$told"; return 1; }
  grep '^-- sightline: without' <<<"$told" || return 1
  whole || { rm -rf "$work"; return 0; }
  cmake --build "$work/core" && cmake --install "$work/core" --prefix "$work/core/prefix" >/dev/null || return 1
  ls "$work"/core/prefix/lib*/*.a "$work"/core/prefix/lib/*/*.a 2>/dev/null
  SIGHTLINE_CAMPAIGN=whole "$build/tests/house_campaign_test" || return 1
  # Shared libraries with a SONAME, and a program that finds them.
  cmake -S . -B "$work/shared" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON -DSIGHTLINE_TESTS=OFF >/dev/null &&
    cmake --build "$work/shared" && cmake --install "$work/shared" --prefix "$work/shared/prefix" >/dev/null || return 1
  find "$work/shared/prefix" -name 'libsightline*.so.*.*.*' -exec sh -c 'readelf -d "$1" | grep SONAME' _ {} \;
  "$work/shared/prefix/bin/sightline" run scenarios/paper_7_1.toml --seed 1 -o "$work/flight" >/dev/null || return 1
  "$build/bin/sightline" run scenarios/paper_7_1.toml --seed 1 -o "$work/static" >/dev/null || return 1
  node tests/npm/same_mcap.mjs "$work"/{static,flight}/run.mcap || return 1
  # The compiler of Ubuntu 22.04.
  cmake -S . -B "$work/old" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=g++-11 -DCMAKE_C_COMPILER=gcc-11 >/dev/null &&
    cmake --build "$work/old" --target sightline_cli math_test formula_test solver_test &&
    "$work/old/bin/sightline" --version &&
    for name in math formula solver; do "$work/old/tests/${name}_test" --gtest_brief=1 || return 1; done
  rm -rf "$work"
}

# GCC and clang print the same kernels and fly every shipped scenario, seed 1, to the same messages. Builds the preset
# clang, library and command line, into build/clang; --short: the kernels alone.
bits() {
  local other=build/clang kernels=$out/clang_kernels name told bad=0 flown=0 side
  local target=sightline_cli
  whole || target=sightline_generate
  cmake --preset clang -DSIGHTLINE_TESTS=OFF -DSIGHTLINE_BENCH=OFF >/dev/null &&
    cmake --build --preset clang --target "$target" | tail -n 1
  ((PIPESTATUS[0] == 0)) && "$other/bin/sightline_generate" "$kernels" && diff -rq "$build/generated/kernels" "$kernels" || return 1
  echo "$(find "$kernels" -name '*.cpp' | wc -l) files of kernels, all the same"
  whole || return 0
  local -a scenarios=(scenarios/*.toml)
  for scenario in "${scenarios[@]}"; do
    name=$(basename "$scenario" .toml)
    for side in "$build" "$other"; do
      "$side/bin/sightline" run "$scenario" --seed 1 -o "$out/$side/$name" >"$out/$name.txt" 2>&1
      (($? <= 1)) || { echo "$side: $scenario did not fly"; tail -n 3 "$out/$name.txt"; bad=$((bad + 1)); continue 2; }
    done
    if told=$(node tests/npm/same_mcap.mjs "$out/$build/$name/run.mcap" "$out/$other/$name/run.mcap" 2>&1); then
      flown=$((flown + 1))
    else
      bad=$((bad + 1))
    fi
    printf '%-40s %s\n' "$scenario" "$told"
    rm -rf "$out/$build/$name" "$out/$other/$name" "$out/$name.txt"
  done
  echo "$flown logs the same, $bad not"
  ((bad == 0 && flown > 0))
}

all=(logs replay package bits)
run_sections "$@"
