#!/usr/bin/env bash
# Every figure that "Ready for the world" asks for, section by section:  scripts/accept/11.sh [--short] [SECTION ...]
# What is finished stays in out/accept/11/ and is not done again; delete it to begin anew. Needs the
# release preset, `npm ci --prefix tests/npm`, and the repository's history. --short is for CI: a
# log against itself.
set -uo pipefail
cd "$(dirname "$0")/../.." || exit 1
build=build/release
. scripts/accept/sections.sh
# The log of every shipped scenario, seed 1, is the same from the commit before the first step to
# the one after the last. "Record a formula in one way" (6d5e99f) alone changed last bits. What came
# before is compared up to its parent, what came after from it.
stretches=('22aaa23 b146855' '6d5e99f 8e55433')

# The command line of a commit, built from the repository's files of then.
built() {
  local at=$out/at/$1
  [[ -x $at/$build/bin/sightline ]] && return
  mkdir -p "$at"
  git archive "$1" | tar -x -C "$at" || return 1
  (cd "$at" && cmake --preset release -DSIGHTLINE_TESTS=OFF && cmake --build --preset release --target sightline_cli) >"$at.log" 2>&1 ||
    { tail -n 5 "$at.log"; return 1; }
}
# What a binary understands of a scenario; warnings are words about it.
team_of() { "$1" check "$2" 2>/dev/null | grep -v '^warning'; }

# $1, $2: a binary and its scenario; $3, $4: those of the other. Whether they fly to the same
# messages, seed 1.
flies_as() {
  local log bad=0
  for log in first second; do
    "$1" run "$2" --seed 1 -o "$out/$log" &>"$out/$log.txt"
    (($? <= 1)) || { echo "$1: $2 does not fly: $(tail -n 1 "$out/$log.txt")"; bad=1; }
    shift 2
  done
  ((bad == 1)) || node tests/npm/same_mcap.mjs "$out"/{first,second}/run.mcap 2>&1 || bad=1
  rm -rf "$out"/{first,second}{,.txt}
  return $bad
}

logs() {
  local first second before after from to name output bad=0 flown=0
  whole || { mkdir -p "$out/at" && ln -s "$PWD" "$out/at/HEAD" && stretches=('HEAD HEAD'); }
  for stretch in "${stretches[@]}"; do
    read -r first second <<<"$stretch"
    ! whole || { built "$first" && built "$second"; } || return 1
    before=$out/at/$first/$build/bin/sightline after=$out/at/$second/$build/bin/sightline
    for from in "$out/at/$first"/scenarios/*.toml; do
      name=$(basename "$from" .toml) to=$out/at/$second/scenarios/$(basename "$from")
      whole || [[ $name == handover ]] || continue
      # A scenario that was written anew is flown by both as it was.
      diff -q <(team_of "$before" "$from") <(team_of "$after" "$to") >/dev/null || {
        to=$from
        name+=' as it was'
      }
      if output=$(flies_as "$before" "$from" "$after" "$to"); then
        flown=$((flown + 1))
      else
        bad=$((bad + 1))
      fi
      printf '%s to %s  %-40s %s\n' "$first" "$second" "$name" "$output"
    done
  done
  echo "$flown logs the same, $bad not"
  ((bad == 0 && flown > 0))
}

# Every shipped scenario, flown with seed 1 and then replayed: no command differs, and in how many
# seconds.
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

# What others get: components without what they do not need, old processors, shared libraries, an
# older compiler.
package() {
  local work name output
  local -a without=()
  work=$(mktemp -d) || return 1
  for name in Boost SQLite3 tomlplusplus nlohmann_json CLI11 ZLIB PkgConfig; do
    without+=("-DCMAKE_DISABLE_FIND_PACKAGE_$name=ON")
  done
  output=$(cmake -S . -B "$work/core" -G Ninja "${without[@]}" 2>&1) || { echo "$output"; return 1; }
  grep '^-- sightline: without' <<<"$output" || return 1
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
    cmake --build "$work/old" --target sightline_cli base_test formula_test solver_test &&
    "$work/old/bin/sightline" --version &&
    for name in base formula solver; do "$work/old/tests/${name}_test" --gtest_brief=1 || return 1; done
  rm -rf "$work"
}

# GCC and clang print the same kernels and fly every shipped scenario, seed 1, to the same messages.
# Builds the preset clang, library and command line, into build/clang; --short: the kernels alone.
bits() {
  local other=build/clang kernels=$out/clang_kernels output bad=0 flown=0
  local target=sightline_cli
  local -a parts  # as compiled here
  mapfile -t parts < <(basename -s .cpp "$build"/generated/kernels/*.cpp | grep -vx index)
  whole || target=sightline_generate
  cmake --preset clang -DSIGHTLINE_TESTS=OFF -DSIGHTLINE_BENCH=OFF >/dev/null &&
    cmake --build --preset clang --target "$target" | tail -n 1
  ((PIPESTATUS[0] == 0)) && "$other/bin/sightline_generate" "$kernels" "${parts[@]}" && diff -rq "$build/generated/kernels" "$kernels" || return 1
  echo "$(find "$kernels" -name '*.cpp' | wc -l) files of kernels, all the same"
  whole || return 0
  local -a scenarios=(scenarios/*.toml)
  for scenario in "${scenarios[@]}"; do
    if output=$(flies_as "$build/bin/sightline" "$scenario" "$other/bin/sightline" "$scenario"); then
      flown=$((flown + 1))
    else
      bad=$((bad + 1))
    fi
    printf '%-40s %s\n' "$scenario" "$output"
  done
  echo "$flown logs the same, $bad not"
  ((bad == 0 && flown > 0))
}

# The benchmark before the first step and today, in turns.
bench() {
  local after=$build/bin/sightline_bench
  whole || { LIMIT=1000 TURNS=1 scripts/accept/bench_turns.sh "$after" "$after" pair; return; }
  built 22aaa23 || return 1
  scripts/accept/bench_turns.sh "$out/at/22aaa23/$build/bin/sightline" "$after"
}

all=(logs replay package bits bench)
run_sections "$@"
