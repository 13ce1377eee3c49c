#!/usr/bin/env bash
# Shows that the fast tests notice when what they guard is broken:  scripts/mutants.sh [BUILD_DIR] [GROUP...]
# Each mutant is one substitution in a copy of its sources; a line tells which test killed it. Nothing in the tree
# changes. Ends with 1 if a mutant survives. BUILD_DIR holds a built library (build/release by default). The groups are
# barrier (the safety filter) and verdicts (summary.json, exit code, outcome of a run of a campaign); all if none is named.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1
build=build/release
if [[ ${1:-} == */* ]]; then build=$1 && shift; fi
[[ -f $build/lib/libsightline_core.a ]] || { echo "mutants.sh: $build = not built, expected lib/libsightline_core.a in it" >&2; exit 2; }
groups=("$@")
((${#groups[@]} > 0)) || groups=(barrier verdicts)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# As the build compiles the library's own barrier, at -O1.
flags=(-std=c++20 -O1 -march=native -ffp-contract=off -fno-math-errno -fno-trapping-math -Wno-psabi -isystem /usr/include/eigen3
  -DSIGHTLINE_SOURCE_DIR="\"$PWD\"" -DSIGHTLINE_BINARY="\"$PWD/$build/bin/sightline\"")

# A group: its sources in src/sightline/, the folder of files that are named without one, its tests in tests/ and their
# filter, objects and libraries beside them, and its mutants:
# name | file | what stands there (a regular expression without |) | what the mutant has in its place
barrier() {
  folder=safety
  sources=(safety/{authority,escape,projection,barrier,barrier_threats,barrier_several,barrier_check,way_out})
  tests=(safety/{authority,escape,projection,barrier,barrier_threats,barrier_several,barrier_check,way_out})
  filter='Authority.*:Escape.*:Projection.NeverTrades*:Barrier*:WaysOut.*'
  objects=(cli/allocations)
  libraries=("$build/lib/libsightline_core.a")
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
    'long periods not checked|barrier.cpp|if (parts_ > 1) {|if (parts_ > 1000) {'
    'motion within a period not checked|barrier_check.cpp|least = std::min(least, norm(q) - rho - wanted);|;'
    'rest of a plan not checked|barrier_check.cpp|least = std::min(least, plans\[k - first\].reserve() - required(\*of\[k\]));|;'
    'dip of a plan within a period left out|escape.cpp|return least - tube.rho0;|return norm(tube.r) - tube.rho0;'
    'share of a member checked doubled|barrier_check.cpp|options_.share \* (gap - wanted)|2 * options_.share * (gap - wanted)'
    'yaw beside a plan|barrier_several.cpp|if (can_.reach\[k\] == 0) continue;|;'
    'bounds of the world not checked|barrier_check.cpp|return least + touched;|return infinity;'
    'floor turned into a ceiling|barrier.cpp|of_wall({0, 0, 1}, 0.0, least, Wall::floor)|of_wall({0, 0, -1}, 0.0, least, Wall::floor)'
  )
}

verdicts() {
  folder=record
  sources=(record/{safety_summary,summary,plan_summary,logged_flight} campaign/judge)
  tests=(record/{safety_summary,summary,plan_summary,logged_flight} campaign/judge run/plan_gap)
  filter='SafetySummary.*:Summary.*:PlanSummary.*:PlanGap*:LoggedFlight.*:Judge.*'
  objects=()
  libraries=("$build/lib/libsightline.a" "$build/lib/libsightline_core.a" -lsqlite3 -lzstd -ltomlplusplus -lz)
  mutants=(
    'states that are no numbers not counted|summary.cpp|!all_finite(sample.x) .. !all|!all'
    'applied inputs that are no numbers not counted|summary.cpp|!all_finite(sample.u) .. !all|!all'
    'raw inputs that are no numbers not counted|summary.cpp| .. !all_finite(sample.raw_u)||'
    'applied inputs not judged|summary.cpp|applied_violations_ += beyond(sample.u\[offset + i\], i) ? 1 : 0;|;'
    'raw inputs not judged|summary.cpp|input_violations_ += beyond(raw, i) ? 1 : 0;|;'
    'upper input limit not judged|summary.cpp| \&\& u <= u_max_\[i\] + raw_tolerance||'
    'lower input limit not judged|summary.cpp|u >= u_min_\[i\] - raw_tolerance \&\& ||'
    'limits of the start judged for ever|summary.cpp|present_.limits(robot.body).at(sample.time, u_min_, u_max_);|present_.limits(robot.body).at(0.0, u_min_, u_max_);'
    'out of view may last twice as long|summary.cpp|lost_after = 2.0;|lost_after = 4.0;'
    'in view is out of view|summary.cpp|violation(observer, target, time) <= 0;|violation(observer, target, time) > 0;'
    'views count before settle|summary.cpp|    if (!settled) continue;||'
    'last distance told as the least|summary.cpp|std::min(least_distance2_, dot(r, r))|dot(r, r)'
    'distance to obstacles not judged|summary.cpp|if (other == robot.body .. (|if (other == robot.body or !team.is_agent(other) or (|'
    'last excess told as the worst|summary.cpp|limit.worst = std::max(limit.worst, excess);|limit.worst = excess;'
    'broken samples not counted|summary.cpp|    ++limit.broken;||'
    'last stretch told as the longest|summary.cpp|limit.longest = std::max(limit.longest, end_ - limit.broken_since);|limit.longest = end_ - limit.broken_since;'
    'errors count from the start|summary.cpp|sample.time < scenario_.simulation.rms_from - same_time|false'
    'errors not squared|summary.cpp|robot.squared_error += dot(e, e);|robot.squared_error += norm(e);'
    'energy without its weights|summary.cpp|robot.energy += period_ \* agent.R\[i\] \* u|robot.energy += period_ * u'
    'a plan that is late ends no gap|run/plan_gap.hpp|if (ends) open = {};|;'
    'last period of a gap left out|run/plan_gap.hpp|open.longest = time + period - open.from;|open.longest = time - open.from;'
    'updates that were not asked for are failures|run/plan_gap.hpp|open_failed_, record.answered \&\& !planned|open_failed_, !planned'
    'no plan for twice as long|plan_summary.cpp|gap.longest <= hold_after_ + same_time|gap.longest <= 2 * hold_after_ + same_time'
    'views make no flight fail|logged_flight.cpp|std::vector<std::string> faults = log.summary().out_of_view();|std::vector<std::string> faults;'
    'lack of plans makes no flight fail|logged_flight.cpp|for (std::string& sentence : log.summary().plans().failures()) faults.push_back(std::move(sentence));|;'
    'broken distances make no flight fail|logged_flight.cpp|for (std::string& sentence : log.summary().safety().broken()) faults.push_back(std::move(sentence));|;'
    'what is no number makes no flight fail|logged_flight.cpp|faults.emplace_back("a state or an input was not finite");|;'
    'a pair of bodies nearer by a half is kept|safety_summary.cpp|return least2 >= d_hard \* d_hard;|return 4 * least2 >= d_hard * d_hard;'
    'walls that are passed are kept|safety_summary.cpp|!(excess > touched)|!(excess > 1e9)'
    'floor and ceiling exchanged|safety_summary.cpp|return bound.limit - p.z;|return p.z - bound.limit;'
    'ceiling not judged|safety_summary.cpp|return p.z - bound.limit;|return -1.0;'
    'world judged along x alone|safety_summary.cpp|std::max(std::abs(p.x), std::abs(p.y))|std::abs(p.x)'
    'what lands has a floor|safety_summary.cpp|!(lands \&\& bound.of == Bound::Of::floor)|true'
    'what lands has no ceiling|safety_summary.cpp|!(lands \&\& bound.of == Bound::Of::floor)|!lands'
    'absent bodies are near|safety_summary.cpp|if (!is_there(pair.a) .. !is_there(pair.b)) continue;|;'
    'input limits of a campaign not judged|campaign/judge.cpp|if (!(u\[i\] >= low\[i\] \&\& u\[i\] <= high\[i\])) return false;|;'
    'nearer by a half is far enough|campaign/judge.cpp|distance < pair.d_hard - same_distance|distance < 0.5 * pair.d_hard'
    'who could not brake is blamed|campaign/judge.cpp|hold \&\& !(pair.could_brake \&\& distance|hold \&\& !(distance'
    'no plan in a campaign not judged|campaign/judge.cpp|if (gaps_\[c\].failed().longest > hold_after_ + same_time)|if (false)'
    'states of a campaign may be no numbers|campaign/judge.cpp|finite = all_finite(sample_.x) \&\& |finite = |'
    'walls of a campaign not judged|campaign/judge.cpp|if (!walls.empty()) return walls.front();|;'
    'a target out of view at the end is recovered|campaign/judge.cpp|at_end = at_end \&\& (view.seen .. !view.asked);|;'
    'a view that came late is in time|campaign/judge.cpp|first <= plan_.view_within|first <= 10 * plan_.view_within'
  )
}

fail() { echo "mutants.sh: $1" >&2; exit 2; }
compile() { c++ "${flags[@]}" "$@" -Isrc -I"$build/generated"; }
prepare() {
  local source
  rm -rf "$work/tests" && mkdir -p "$work/tests"
  for source in "${tests[@]/%/_test}"; do
    compile -I. -c "tests/$source.cpp" -o "$work/tests/${source//\//_}.o" || fail "tests/$source.cpp does not compile"
  done
  for source in "${objects[@]}"; do
    compile -I. -c "$source.cpp" -o "$work/tests/${source//\//_}.o" || fail "$source.cpp does not compile"
  done
}

# $1: a tree of the sources, and objects of those that need no compiling. Linked before the library, they stand for its own,
# which others of its batch may bring along.
program() {
  local source
  for source in "${sources[@]}"; do
    [[ -f $1/sightline/$source.o ]] || compile -I"$1" -c "$1/sightline/$source.cpp" -o "$1/sightline/$source.o" || return 1
  done
  c++ -Wl,--allow-multiple-definition "$1"/sightline/*/*.o "$work"/tests/*.o "${libraries[@]}" \
    -lgtest_main -lgmock -lgtest -lfmt -lpthread -o "$1/tests" || return 1
}

# The mutant of $1 in the tree $2.
mutate() {
  local name file from to user
  IFS='|' read -r name file from to <<<"$1"
  [[ $file == */* ]] || file=$folder/$file
  mkdir -p "$2/sightline/${file%/*}"
  rm -f "$2/sightline/${file%.*}.o" "$2/tests"
  sed "s|$from|$to|" "src/sightline/$file" >"$2/sightline/$file"
  cmp -s "$2/sightline/$file" "src/sightline/$file" && fail "mutant \"$name\" changes nothing, expected \"$from\" in $file"
  [[ $file == *.hpp ]] || return 0
  # All of its layer may include a header, as the tests may, which then stand beside the sources.
  for user in "${sources[@]}"; do rm -f "$2/sightline/$user.o"; done
}

run_group() {
  local mutant name source tree
  prepare
  tree=$work/none
  rm -rf "$tree"
  for source in "${sources[@]}"; do
    mkdir -p "$tree/sightline/${source%/*}"
    cp "src/sightline/$source.cpp" "$tree/sightline/$source.cpp"
  done
  program "$tree" || fail "the sources of group $1 do not build"
  "$tree/tests" --gtest_filter="$filter" >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "the tests of group $1 fail without a mutant"; }
  for mutant in "${mutants[@]}"; do
    name=${mutant%%|*}
    tree=$work/mutant
    rm -rf "$tree" && cp -r "$work/none" "$tree"
    mutate "$mutant" "$tree"
    program "$tree" 2>"$work/log" || { cat "$work/log" >&2; fail "mutant \"$name\" does not build"; }
    if timeout 300 "$tree/tests" --gtest_filter="$filter" --gtest_fail_fast >"$work/log" 2>&1; then
      echo "SURVIVED  $name"
      survivors=$((survivors + 1))
    else
      echo "killed    $name: $(sed -nE 's/^\[  FAILED  \] ([A-Za-z.]+).*/\1/p' "$work/log" | head -1)"
    fi
  done
  count=$((count + ${#mutants[@]}))
}

begin=$SECONDS
count=0
survivors=0
for group in "${groups[@]}"; do
  declare -F "$group" >/dev/null || fail "group $group = not known, expected barrier or verdicts"
  "$group"
  run_group "$group"
done
echo "$count mutants, $survivors survived, $((SECONDS - begin)) s"
((survivors == 0))
