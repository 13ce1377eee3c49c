#!/usr/bin/env bash
# Shows that the fast tests of the barrier notice when it is broken:  scripts/mutants.sh [BUILD_DIR]
# Each mutant is one substitution in a copy of its sources; a line tells which test killed it. Nothing in the tree
# changes. Ends with 1 if a mutant survives. BUILD_DIR holds a built library (build/release by default).
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1
build=${1:-build/release}
[[ -f $build/lib/libsightline_core.a ]] || { echo "mutants.sh: $build = not built, expected lib/libsightline_core.a in it" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# As the build compiles the library's own barrier, at -O1.
flags=(-std=c++20 -O1 -march=native -ffp-contract=off -fno-math-errno -fno-trapping-math -Wno-psabi)
sources=(authority escape projection barrier barrier_threats barrier_several way_out)
tests=(authority escape projection barrier barrier_threats barrier_several way_out)
filter='Authority.*:Escape.*:Projection.NeverTrades*:Barrier*:WaysOut.*'

# name | file | what stands there | what the mutant has in its place
mutants=(
  'sign of the normal flipped|barrier_threats.hpp|return least - value(next);|return least + value(next);'
  'sign of the velocity flipped|barrier_threats.hpp|n.x \* (E \* next.v.x + push.x)|n.x * (push.x - E * next.v.x)'
  'sign of the thrust flipped|escape.cpp|const S side = where_negative(g.x \* x\[k\] + g.y \* y\[k\], S(-1.0), S(1.0));|const S side = where_negative(g.x * x[k] + g.y * y[k], S(1.0), S(-1.0));'
  'drag dropped|barrier.cpp|plans_(can_.drag, dt)|plans_(0.0, dt)'
  'deceleration doubled|authority.cpp|const double reach = part|const double reach = 2 * part'
  'deceleration of members doubled|barrier_threats.cpp|tube.beta = both \* 2 \* b_;|tube.beta = both * 4 * b_;'
  'margin zero|barrier_threats.cpp|n.d_hard + options_.margin + 3 \* n.sigma|n.d_hard'
  'margin of age zero|barrier_threats.cpp|tube.rho0 += n.speed_max \* age;|;'
  'speed of a stranger halved|barrier_threats.cpp|tube.speed = n.speed_max;|tube.speed = 0.5 * n.speed_max;'
  'share of a member doubled|barrier.cpp|options_.share \* spare|2 * options_.share * spare'
  'step not looked ahead|barrier.cpp|const EscapeShape left = plans_.left(touch);|const EscapeShape left = touch.shape;'
  'cuts left out|barrier.cpp|    add_cuts(self, there, rows);||'
  'floor traded for a distance|barrier.cpp|h.hard = row.wall != Wall::none;|h.hard = false;'
  'hard rows missed as others are|projection.cpp|missable(row) ? slack_part : 0.0|slack_part'
  'several each for itself|barrier_several.cpp|if (uncooperative.size() < 2) return infinity;|return infinity;'
  'other corners not looked at|escape.cpp|if (a.x == plan.a.x \&\& a.y == plan.a.y) continue;|continue;'
  'nothing looked at below a ceiling|barrier_several.cpp|if (speed != 0 \&\& room == 0) continue;|if (speed != 0 \&\& room == 0) break;'
  'plan for several climbs twice as fast|escape.cpp|clamp(tube.climb \* t, -tube.room, tube.room)|clamp(S(2.0) * tube.climb * t, -tube.room, tube.room)'
  'height lags behind the plan|barrier_several.cpp|side \* self.p.z + step - lag|side * self.p.z + step - 1.0'
  'lag of the climb ignored|barrier.cpp|self.p.z += can_.climb_lag \* self.v.z;|self.p.z += 0.0 * self.v.z;'
  'limits that are left ignored|authority.cpp|return std::max(least, (left - (1.0 - free)) / free);|return 1.0;'
  'part of a member ignored|barrier_threats.cpp|std::min(part, n.part)|part'
  'margin of the floor zero|barrier.cpp|options_.floor += options_.wall_margin;|;'
  'ring not noticed|barrier.cpp|  if (lost) {|  if (lost \&\& joint > 1.0) {'
  'chasers stand still|way_out.cpp|Pack(chaser.speed \* step.h)|Pack(0.0 * step.h)'
  'way out flown the other way|barrier_several.cpp|step.e \* self.v.x + step.E \* a.x|step.e * self.v.x - step.E * a.x'
  'floor turned into a ceiling|barrier.cpp|of_wall({0, 0, 1}, 0.0, least, Wall::floor)|of_wall({0, 0, -1}, 0.0, least, Wall::floor)'
)

fail() { echo "mutants.sh: $1" >&2; exit 2; }
prepare() {
  local test
  for test in "${tests[@]}"; do
    c++ "${flags[@]}" -isystem /usr/include/eigen3 -I. -Isrc -I"$build/generated" -c "tests/safety/${test}_test.cpp" \
      -o "$work/${test}_test.o" || fail "tests/safety/${test}_test.cpp does not compile"
  done
  c++ "${flags[@]}" -I. -Isrc -I"$build/generated" -c cli/allocations.cpp -o "$work/allocations.o" || fail "cli/allocations.cpp does not compile"
}

# $1: folder with the sources, and objects of those that need no compiling. Links them before the library, so that they stand for its own.
program() {
  local source
  for source in "${sources[@]}"; do
    [[ -f $1/$source.o ]] || c++ "${flags[@]}" -I"$1" -Isrc -I"$build/generated" -c "$1/$source.cpp" -o "$1/$source.o" || return 1
  done
  c++ "$1"/*.o "$work"/*_test.o "$work/allocations.o" "$build/lib/libsightline_core.a" \
    -lgtest_main -lgmock -lgtest -lfmt -lpthread -o "$1/tests" || return 1
}

begin=$SECONDS
survivors=0
prepare
mkdir -p "$work/none/sightline/safety"
cp src/sightline/safety/barrier_threats.hpp "$work/none/sightline/safety"
for source in "${sources[@]}"; do cp "src/sightline/safety/$source.cpp" "$work/none"; done
program "$work/none" || fail "the barrier does not build"
"$work/none/tests" --gtest_filter="$filter" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "the tests fail without a mutant"; }
for mutant in "${mutants[@]}"; do
  IFS='|' read -r name file from to <<<"$mutant"
  folder=$work/mutant
  rm -rf "$folder" && cp -r "$work/none" "$folder" && rm -f "$folder/${file%.cpp}.o" "$folder/tests"
  mutated=$folder/$file
  [[ $file == *.hpp ]] && mutated=$folder/sightline/safety/$file && rm -f "$folder"/barrier*.o
  sed -i "s|$from|$to|" "$mutated"
  cmp -s "$mutated" "src/sightline/safety/$file" && fail "mutant \"$name\" changes nothing, expected \"$from\" in $file"
  program "$folder" 2>"$work/log" || { cat "$work/log" >&2; fail "mutant \"$name\" does not build"; }
  if timeout 300 "$folder/tests" --gtest_filter="$filter" --gtest_fail_fast >"$work/log" 2>&1; then
    echo "SURVIVED  $name"
    survivors=$((survivors + 1))
  else
    echo "killed    $name: $(sed -nE 's/^\[  FAILED  \] ([A-Za-z.]+).*/\1/p' "$work/log" | head -1)"
  fi
done
echo "${#mutants[@]} mutants, $survivors survived, $((SECONDS - begin)) s"
((survivors == 0))
