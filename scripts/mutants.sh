#!/usr/bin/env bash
# Shows that the fast tests notice when what they guard is broken:  scripts/mutants.sh [BUILD_DIR | --check] [GROUP...]
# Each mutant is one substitution in a copy of its sources; a line names the test that killed it.
# Nothing in the tree changes.
# --check builds nothing: it shows that each mutant changes its file. Ends with 1 if a mutant survives or does not build. BUILD_DIR holds a built library (build/release by default). The groups are
# barrier (the safety filter), verdicts (summary.json, exit code, outcome of a run of a campaign),
# gate (what is measured and what is applied), solver (the Newton update) and estimate (the pose
# filters); all if none is named.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1
build=build/release
check=
if [[ ${1:-} == --check ]]; then check=1 && shift
elif [[ ${1:-} == */* ]]; then build=$1 && shift; fi
[[ -n $check || -f $build/lib/libsightline_core.a ]] || { echo "mutants.sh: $build = not built, expected lib/libsightline_core.a in it" >&2; exit 2; }
groups=("$@")
((${#groups[@]} > 0)) || groups=(barrier verdicts gate solver estimate)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# As the build compiles the library's own barrier, at -O1.
flags=(-std=c++20 -O1 -march=native -ffp-contract=off -fno-math-errno -fno-trapping-math -Wno-psabi -isystem /usr/include/eigen3
  -DSIGHTLINE_SOURCE_DIR="\"$PWD\"" -DSIGHTLINE_BINARY="\"$PWD/$build/bin/sightline\"")

# A group: its sources in src/sightline/, the folder of files that are named without one, its tests
# in tests/ and their filter, the fast ones first, objects and libraries beside them, and its
# mutants:
# name | file | what stands there (a regular expression without |) | what the mutant has in its place
barrier() {
  folder=safety
  sources=(safety/{authority,escape,projection,barrier,barrier_law,barrier_threats,joint_plan,barrier_rows,row_projection,surrounded}
    safety/{barrier_check,driving_barrier,evasive_maneuver})
  tests=(safety/{authority,escape,projection,barrier,barrier_threats,barrier_several,barrier_check,driving_barrier,residual_acceleration,evasive_maneuver,zone,thrust_lag})
  filter='Authority.*:Escape.*:Projection.NeverTrades*:Barrier*:DrivingBarrier.*:ResidualAcceleration.*:EvasiveManeuvers.*:Zone.*:ThrustLag.*Plan*'
  objects=(cli/allocations tests/support/counting_new)
  libraries=("$build/lib/libsightline_core.a")
  mutants=(
    'sign of the normal flipped|barrier_period.hpp|return least - value(next);|return least + value(next);'
    'sign of the velocity flipped|barrier_period.hpp|n.x \* (E \* next.v.x + push.x)|n.x * (push.x - E * next.v.x)'
    'sign of the thrust flipped|escape.cpp|const S side = where_negative(g.x \* x\[k\] + g.y \* y\[k\], S(-1.0), S(1.0));|const S side = where_negative(g.x * x[k] + g.y * y[k], S(1.0), S(-1.0));'
    'drag dropped|barrier_law.cpp|plans(can.drag, dt, can.thrust_lag)|plans(0.0, dt, can.thrust_lag)'
    'lag of the tilt dropped|barrier_law.cpp|plans(can.drag, dt, can.thrust_lag)|plans(can.drag, dt, 0.0)'
    'deceleration doubled|authority.cpp|const double reach = part|const double reach = 2 * part'
    'deceleration of members doubled|barrier_threats.cpp|tube.beta = both \* 2 \* law.b;|tube.beta = both * 4 * law.b;'
    'margin zero|barrier_threats.cpp|n.d_hard + law.options.margin + 3 \* n.sigma|n.d_hard'
    'margin of age zero|barrier_threats.cpp|tube.rho0 += n.speed_max \* age;|;'
    'speed of a stranger halved|barrier_threats.cpp|tube.speed += n.speed_max;|tube.speed += 0.5 * n.speed_max;'
    'share of a member doubled|barrier_rows.cpp|law.options.share \* spare|2 * law.options.share * spare'
    'step not looked ahead|barrier_rows.cpp|const EscapeShape left = law.plans.left(touch);|const EscapeShape left = touch.shape;'
    'cuts left out|row_projection.cpp|    add_cuts(law, there, now);||'
    'floor traded for a distance|row_projection.cpp|h.hard = row.wall != Wall::none;|h.hard = false;'
    'hard rows missed as others are|projection.cpp|missable(row) ? slack_part : 0.0|slack_part'
    'several each for itself|joint_plan.cpp|if (uncooperative.size() < 2) return infinity;|return infinity;'
    'other corners not looked at|escape.cpp|if (a.x == plan.a.x \&\& a.y == plan.a.y) continue;|continue;'
    'nothing looked at below a ceiling|joint_plan.cpp|if (speed != 0 \&\& room == 0) continue;|if (speed != 0 \&\& room == 0) break;'
    'plan for several climbs twice as fast|escape.cpp|clamp(tube.climb \* t, -tube.room, tube.room)|clamp(S(2.0) * tube.climb * t, -tube.room, tube.room)'
    'height lags behind the plan|joint_plan.cpp|side \* now.self.p.z + step - lag|side * now.self.p.z + step - 1.0'
    'lag of the climb ignored|barrier_law.cpp|self.p.z += can.climb_lag \* self.v.z;|self.p.z += 0.0 * self.v.z;'
    'limits that are left ignored|authority.cpp|return std::max(least, (left - (1.0 - free)) / free);|return 1.0;'
    'part of a member ignored|barrier_threats.cpp|std::min(now.part, n.part)|now.part'
    'margin of the floor zero|barrier_law.cpp|options.floor += options.wall_margin;|;'
    'ring not noticed|barrier.cpp|  if (lost) {|  if (lost \&\& joint > 1.0) {'
    'chasers stand still|evasive_maneuver.cpp|Pack(chaser.speed \* step.h)|Pack(0.0 * step.h)'
    'way out flown the other way|surrounded.cpp|now.lagging, a, law.dt|now.lagging, {-a.x, -a.y}, law.dt'
    'long periods not checked|barrier.cpp|if (law.parts > 1 |if (law.parts > 1000 '
    'motion within a period not checked|barrier_check.cpp|least = std::min(least, norm(q) - rho - wanted);|;'
    'rest of a plan not checked|barrier_check.cpp|least = std::min(least, plans\[k - first\].reserve() - required(\*of\[k\]));|;'
    'dip of a plan within a period left out|escape.cpp|return least - tube.rho0;|return norm(tube.r) - tube.rho0;'
    'share of a member checked doubled|barrier_check.cpp|law.options.share \* (gap - wanted)|2 * law.options.share * (gap - wanted)'
    'yaw beside a plan|barrier_law.cpp|if (can.reach\[k\] == 0) continue;|;'
    'bounds of the world not checked|barrier_check.cpp|return least + touched;|return infinity;'
    'floor turned into a ceiling|barrier_rows.cpp|heights.push_back({1.0, floor,|heights.push_back({-1.0, floor,'
    'first face of a piece taken|barrier_rows.cpp|if (reserve > most) most|if (!by_plane) most'
    'pursuer slow while a robot brakes|driving_barrier.cpp|one.speed \* (law_.dt + after.time)|one.speed * law_.dt'
    'share of a driving member trebled|driving_barrier.cpp|law_.options.share \* (h - wanted_of(h))|3 * law_.options.share * (h - wanted_of(h))'
    'last period braked as the others|barrier_law.cpp|periods > 1 ? last.e|periods > 0 ? last.e'
    'braking path between samples left out|driving_barrier.cpp|k < flown.between.size(); ++k|k < 0; ++k'
    'braking path of a member left out|driving_barrier.cpp|{n.v.x, n.v.y}, std::min(n.part|{0, 0}, std::min(n.part'
    'braking path of a robot left out|driving_barrier.cpp|return {p, {v.x / speed, v.y / speed}, stop.length|return {p, {v.x / speed, v.y / speed}, 0.0 * stop.length'
    'bounds of a robot that drives left out|driving_barrier.cpp|: now.planes) conditions.add(plane);|: now.planes) (void)plane;'
    'near bodies taken for far ones|driving_barrier.cpp|if (spare >= shift_) return;|if (spare >= 0.1 * shift_) return;'
    'residual acceleration of a pair counted once|barrier_threats.cpp|2 \* law.options.residual_acceleration|law.options.residual_acceleration'
    'residual acceleration during a delay left out|barrier_threats.cpp|tube.spread += w \* law.plans.E(delay);|;'
    'residual acceleration of a period left out of walls|barrier_rows.cpp|left.E \* law.next_predicted.v|0.0 * law.next_predicted.v'
    'residual acceleration not braked against|barrier_law.cpp|part \* b - options.residual_acceleration,|part * b,'
    'bend of a plan bounded from the wrong side|escape.cpp|std::min(at.A \* from.e, at.A \* to.e)|std::max(at.A * from.e, at.A * to.e)'
    'plan of the period before forgotten|barrier.cpp|now.plan_before = maneuver.plan;|;'
    'command of a proven plan not trusted|barrier_check.cpp|leaves = std::max(leaves, known);|;'
    'command of a proven plan turned with the heading|barrier_law.cpp|const Vec2<double> turned = rotate(coasting.d, rotate<double>({self.d.x, -self.d.y}, a)),|const Vec2<double> turned = a,'
    'margin of a zone zero|barrier_law.cpp|face.offset += margin;|;'
  )
}

verdicts() {
  folder=judge
  sources=(judge/{safety_summary,sampled_motion,input_record,tracking_error,present_team,drift,summary,plan_summary,run_evaluator} record/logged_flight)
  tests=(judge/{safety_summary,input_record,tracking_error,summary,plan_summary} run/plan_gap judge/run_evaluator
    judge/{sampled_motion,drift} record/logged_flight)
  filter='SafetySummary.*:SampledMotion.*:InputRecord.*:TrackingError.*:Drift.*:Summary.*:PlanSummary.*:PlanGap*:LoggedFlight.*:RunEvaluator*'
  objects=()
  libraries=("$build/lib/libsightline.a" "$build/lib/libsightline_core.a" -lsqlite3 -llz4 -lzstd -ltomlplusplus -lz)
  mutants=(
    'states that are no numbers not counted|input_record.cpp|return all_finite(sample.x) \&\&|return'
    'applied inputs that are no numbers not counted|input_record.cpp|all_finite(sample.u) \&\& ||'
    'raw inputs that are no numbers not counted|input_record.cpp| \&\& all_finite(sample.raw_u)||'
    'what is no number not counted|summary.cpp|if (!all_finite(sample)) ++not_finite_;|;'
    'applied inputs not judged|input_record.cpp|  beyond_ += beyond(u) ? 1 : 0;|;'
    'raw inputs not judged|input_record.cpp|raw_beyond_ += beyond(raw) ? 1 : 0;|;'
    'upper input limit not judged|input_record.cpp| \&\& u <= high + input_tolerance||'
    'lower input limit not judged|input_record.cpp|u >= low - input_tolerance \&\& ||'
    'input limits of the start judged for ever|input_record.cpp|limits.at(sample.time, low, high);|limits.at(0.0, low, high);'
    'inputs held through missed periods not judged|input_record.cpp|high\[i\]) ? 0 : 1;|high[i]) ? 0 : 0;'
    'inputs held after the last command judged|input_record.cpp|held_beyond_ += is_within|beyond_ += is_within'
    'once beyond, all inputs are|input_record.cpp|^  within_ = true;|;'
    'the last input alone decides|input_record.cpp|within_ = within_ \&\& !beyond(u);|within_ = !beyond(u);'
    'inputs of what is absent judged|input_record.cpp|== Presence::absent) continue;|== Presence::absent) {}'
    'largest raw input without its sign|input_record.cpp|std::max(largest_raw_, std::abs(raw))|std::max(largest_raw_, raw)'
    'energy without its weights|input_record.cpp|period_ \* agent.R\[i\] \* u|period_ * u'
    'last rate told as the largest|input_record.cpp|std::max(robot.rate_ratio, rate / agent.rate_max\[i\])|rate / agent.rate_max[i]'
    'rates over one period, however long it was|input_record.cpp|(sample.time - robot.time_before)|period_'
    'chatter against a range of its own|input_record.cpp|sample.time, u, high\[i\] - low\[i\]|sample.time, u, 2.0'
    'errors count from the start|tracking_error.cpp|time < from_ - same_time|false'
    'errors not squared|tracking_error.cpp|  squares_ += dot(e, e);|  squares_ += norm(e);'
    'heading errors the wrong way round|tracking_error.cpp|d.x \* seen.d.y - d.y|d.x * seen.d.y + d.y'
    'heading errors where none is required|tracking_error.cpp|if (to_heading \&\& !(d.x|if (!(d.x'
    'position errors where none is required|tracking_error.cpp|if (!to_place) return;|;'
    'steady part left in the rest|tracking_error.cpp|mean_square - std::min(mean_square, offset2)|mean_square'
    'in view is out of view|present_team.cpp|violation(observer, target, time) <= 0;|violation(observer, target, time) > 0;'
    'what lands drifts|drift.cpp|lands_\[i\] ? nullptr : present|present'
    'drift judged at each sample|drift.cpp| .. !due(sample.time)) return;|) return;'
    'out of view may last twice as long|summary.cpp|lost_after = 2.0;|lost_after = 4.0;'
    'views count before settle|summary.cpp|    if (!settled) continue;||'
    'last excess told as the worst|summary.cpp|limit.worst = std::max(limit.worst, excess);|limit.worst = excess;'
    'broken samples not counted|summary.cpp|    ++limit.broken;||'
    'last stretch told as the longest|summary.cpp|limit.longest = std::max(limit.longest, end_ - limit.broken_since);|limit.longest = end_ - limit.broken_since;'
    'a plan that is late ends no gap|run/plan_gap.hpp|if (ends) open = {};|;'
    'last period of a gap left out|run/plan_gap.hpp|open.longest = time + period - open.from;|open.longest = time - open.from;'
    'updates that were not asked for are failures|run/plan_gap.hpp|open_failed_, record.answered \&\& !planned|open_failed_, !planned'
    'no plan for twice as long|plan_summary.cpp|gap.longest <= hold_after_ + same_time|gap.longest <= 2 * hold_after_ + same_time'
    'views make no flight fail|record/logged_flight.cpp|std::vector<std::string> faults = log.summary().out_of_view();|std::vector<std::string> faults;'
    'lack of plans makes no flight fail|record/logged_flight.cpp|for (std::string& sentence : log.summary().plans().failures()) faults.push_back(std::move(sentence));|;'
    'broken distances make no flight fail|record/logged_flight.cpp|for (std::string& sentence : log.summary().safety().broken()) faults.push_back(std::move(sentence));|;'
    'what is no number makes no flight fail|record/logged_flight.cpp|faults.emplace_back("a state or an input was not finite");|;'
    'inputs beyond limits make no flight fail|record/logged_flight.cpp|beyond = log.summary().applied_violations(); beyond > 0|beyond = 0; beyond > 0'
    'last excess beyond told as the worst|safety_summary.cpp|if (most.value > worst_.value) worst_ = most;|worst_ = most;'
    'a start outside forgiven without the key|safety_summary.cpp|excused_ = excused \&\& excess > tolerance_;|excused_ = excess > tolerance_;'
    'a start outside that is meant breaks|safety_summary.cpp|excused_ = excused \&\& excess > tolerance_;|excused_ = false;'
    'a start outside is meant for ever|safety_summary.cpp|^  excused_ = false;|  ;'
    'where it comes within not judged|safety_summary.cpp|^  return raise({excess, time});|  return false;'
    'where it begins told of one that never came within|safety_summary.cpp|if (most.value > start_.value) start_ = most;|;'
    'broken for whole periods|safety_summary.cpp|across = was != is ? .*;|across = 1.0;'
    'broken only where it is at the end|safety_summary.cpp|beyond = was .. is ?|beyond = is ?'
    'last stretch told as all that was broken|safety_summary.cpp|    broken_for_ += beyond;|    broken_for_ = beyond;'
    'last stretch told as all that was outside|safety_summary.cpp|outside_for_ += beyond;|outside_for_ = beyond;'
    'a millimetre nearer than d_hard is kept|safety_summary.cpp|distance_tolerance = 1e-9;|distance_tolerance = 1e-3;'
    'a millimetre beyond a wall is kept|safety_summary.cpp|wall_tolerance = 1e-6;|wall_tolerance = 1e-3;'
    'distance to obstacles not judged|safety_summary.cpp|if (team.is_agent(a) .. team.is_agent(b))|if (team.is_agent(a) \&\& team.is_agent(b))'
    'brakes in half of the way|safety_summary.cpp|closing \* closing / (2 \* braking)|closing * closing / (4 * braking)'
    'those that part have to brake|safety_summary.cpp|std::max(0.0, -dot(r, a.v - b.v) / distance)|std::abs(dot(r, a.v - b.v) / distance)'
    'brakes of those that were there again|safety_summary.cpp|    pair.met = true;|;'
    'who could not brake is blamed|safety_summary.cpp|(broken \&\& pair.could_brake)|broken'
    'too close only at the end|safety_summary.cpp|too_close_ = too_close_ .. too_close_now_;|too_close_ = too_close_now_;'
    'missed periods not counted|safety_summary.cpp|unseen_ += std::llround(event.value);|;'
    'missed periods that were seen are unseen|safety_summary.cpp|event.kind == EventKind::missed_period \&\& !sample.truth_known|event.kind == EventKind::missed_period'
    'shares of the barrier over states too|safety_summary.cpp|^  if (sample.of != Sample::Of::update) return;|;'
    'absent bodies are near|safety_summary.cpp|if (!pair.there) return pair.limit.cease();|;'
    'distances between samples left out|safety_summary.cpp|if (is_near \&\& moved) motion_|if (false) motion_'
    'pairs that come far apart not followed back|safety_summary.cpp|(moved ? motion_.reach(pair.a) + motion_.reach(pair.b) : 0.0)|0.0'
    'reach of one of a pair left out|safety_summary.cpp|motion_.reach(pair.a) + motion_.reach(pair.b)|motion_.reach(pair.a)'
    'last distance told as the least|safety_summary.cpp|if (nearest.value < pair.least.value) pair.least = nearest;|pair.least = nearest;'
    'who joins too near is forgiven|safety_summary.cpp|    broken = !pair.limit.kept().*|    broken = false;'
    'what lands has a floor|safety_summary.cpp|if (lands \&\& bound.of == Bound::Of::floor)|if (false)'
    'who lands again is blamed|safety_summary.cpp|return bound.limit.pause();|return bound.limit.cease();'
    'what lands has no ceiling|safety_summary.cpp|if (lands \&\& bound.of == Bound::Of::floor)|if (lands)'
    'what ceases to land is judged at once|safety_summary.cpp|start_outside_ .. was_there|start_outside_'
    'walls between samples left out|safety_summary.cpp|if (motion_.moved(bound.robot) \&\& excess|if (false \&\& excess'
    'what comes back within is not followed|safety_summary.cpp|excess + motion_.reach(bound.robot) >|excess >'
    'the first step of a motion alone|safety_summary.cpp|k + 1 < knots.size(); ++k) find_greatest|k < 1; ++k) find_greatest'
    'world judged along x alone|safety_summary.cpp|{0, 1, 0}, {0, -1, 0}}};|{1, 0, 0}, {-1, 0, 0}}};'
    'floor and ceiling exchanged|safety_summary.cpp|of == Bound::Of::floor ? 0 : 1|of == Bound::Of::floor ? 1 : 0'
    'what drives has a floor|safety_summary.cpp|if (has_height(team.model(body))) {|if (true) {'
    'least distance on the chord|sampled_motion.cpp|= off_chord \* h \* (norm(a.v - w) + norm(b.v - w));|= 0.0;'
    'greatest height on the chord|sampled_motion.cpp|= off_chord \* h \* (std::abs(dot(n, a.v) - w) + std::abs(dot(n, b.v) - w));|= 0.0;'
    'second half of a motion left out|sampled_motion.cpp|  find_least_distance(middle, b, least, depth - 1);|;'
    'extremes to a centimetre|sampled_motion.cpp|close_enough = 1e-5;|close_enough = 1e-2;'
    'time of the least distance is that of the sample|sampled_motion.cpp|least = {reached, a.time + s \* h};|least = {reached, a.time};'
    'models in steps of half a second|sampled_motion.cpp|longest_step = 0.02;|longest_step = 0.5;'
    'reach halved|sampled_motion.cpp|body.reach += 0.5 \* period_|body.reach += 0.05 * period_'
    'reach of a straight line|sampled_motion.cpp|    body.reach += 0.5.*|;'
    'reach without its chord|sampled_motion.cpp|body.reach = norm(d);|;'
    'measured states move|sampled_motion.cpp|begun_ \&\& truth_ \&\& sample.truth_known \&\& period_ > 0|begun_ \&\& period_ > 0'
    'what joins moves|sampled_motion.cpp|if (!known \(..\) !was_there .. |if (!known \1 '
    'what is put elsewhere moves|sampled_motion.cpp|body.moved = norm(d) <= .*|body.moved = true;'
    'velocity that a model lacks left out|sampled_motion.cpp|missing = (1 / T) \* e_p - 0.5 \* e_v;|missing = (1 / T) * e_p;'
    'acceleration that a model lacks left out|sampled_motion.cpp|(0.5 \* s \* s / T) \* e_v|(0.0 * s) * e_v'
    'inputs that come fly what was|sampled_motion.cpp|  if (known) divide();|  delay_.give(time_, sample.u); if (known) divide();'
    'what comes into force between two samples left out|sampled_motion.cpp|row + 1 < rows_most \&\& next < end - 2 \* jump|false'
    'a distance that commands lead to late not reckoned with|sampled_motion.cpp|if (delays_) {|if (false) {'
    'input limits of a campaign not judged|run_evaluator.cpp|good = finite \&\& inputs_.within();|good = finite;'
    'numbers of a campaign not judged|run_evaluator.cpp|good = finite \&\& inputs_.within();|good = inputs_.within();'
    'states after the last command may be no numbers|run_evaluator.cpp|if (!finite) blame(Fault::not_finite);|;'
    'events of a campaign not followed|run_evaluator.cpp|changed = present_.follow(sample_);|changed = false;'
    'drift of a team that is another one goes on|run_evaluator.cpp|if (changed) drift_.restart(couplings);|;'
    'no plan in a campaign not judged|run_evaluator.cpp|if (gaps_\[c\].failed().longest > hold_after_ + same_time)|if (false)'
    'walls of a campaign not judged|run_evaluator.cpp|if (!walls.empty()) return walls.front();|;'
    'too close is recovered|run_evaluator.cpp|safety_.too_close()  ? Outcome::too_close|false ? Outcome::too_close'
    'a target out of view at the end is recovered|run_evaluator.cpp|at_end = at_end \&\& (view.seen .. !view.requested);|;'
    'a view that came late is in time|run_evaluator.cpp|first <= plan_.view_within|first <= 10 * plan_.view_within'
  )
}

gate() {
  folder=world
  sources=(world/command run/{valid_states,loop,stages/team_change})
  tests=(world/command run/valid_states scenario/applied_limits)
  filter='CommandGate.*:ValidStates.*:AppliedLimits.*'
  objects=()
  libraries=("$build/lib/libsightline.a" "$build/lib/libsightline_core.a" -lsqlite3 -llz4 -lzstd -ltomlplusplus -lz)
  mutants=(
    'what is not finite is applied|command.cpp|is_finite = is_finite \&\& std::isfinite(sum(k));|;'
    'what is not finite becomes zero|command.cpp|is_finite ? sum(k) : applied_\[k\]|is_finite ? sum(k) : 0.0'
    'one input of a robot is replaced alone|command.cpp|is_finite ? sum(k) : applied_\[k\]|std::isfinite(sum(k)) ? sum(k) : applied_[k]'
    'limits not kept by the gate|command.cpp|std::clamp(is_finite ? sum(k) : applied_\[k\], u_min_\[k\], u_max_\[k\])|is_finite ? sum(k) : applied_[k]'
    'what is held ignores limits that narrow|command.cpp|std::clamp(is_finite ? sum(k) : applied_\[k\], u_min_\[k\], u_max_\[k\])|is_finite ? std::clamp(sum(k), u_min_[k], u_max_[k]) : applied_[k]'
    'what is beyond a limit not reported|command.cpp|if (!is_finite .. !is_within) rep|if (!is_finite) rep'
    'what is not finite not reported|command.cpp|if (!is_finite .. !is_within) rep|if (!is_within) rep'
    'rounding reported|command.cpp|rounding = 1e-9|rounding = 0.0'
    'a percent beyond a limit not reported|command.cpp|rounding = 1e-9|rounding = 1e-2'
    'beyond an upper limit not reported|command.cpp|u > high + rounding \* (1 + std::abs(high))|false'
    'beyond a lower limit not reported|command.cpp|u < low - rounding \* (1 + std::abs(low))|false'
    'reports of the pass before stay|command.cpp|  replaced_.clear();|;'
    'what is added not counted at the gate|command.cpp|added.empty() ? u\[k\] : u\[k\] + added\[k\]|u[k]'
    'limits of the start in force for ever|command.cpp|robot.limits->at(t, std|robot.limits->at(0.0, std'
    'limits of an event not taken|command.cpp|robots_\[i\].limits = \&limits\[i\];|(void)limits;'
    'limits of the first robot for all|command.cpp|\&limits\[i\]|\&limits[0]'
    'rates a hundred times as fast|command.cpp|rate_max\[i\] \* period_|rate_max[i]'
    'rates not kept|command.cpp|if (!rate_max.empty()) {|if (false) {'
    'rates before lower limits|command.cpp|std::clamp(applied_\[k\] - most, low, high)|(applied_[k] - most)'
    'rates before upper limits|command.cpp|std::clamp(applied_\[k\] + most, low, high)|std::max(low, applied_[k] + most)'
    'rates from rest|command.cpp|std::clamp(applied_\[k\] + most, low, high)|std::clamp(most, low, high)'
    'limits of u alone without what is added|command.cpp|std::clamp(u\[k\], low - by, high - by)|std::clamp(u[k], low, high)'
    'a start beyond its limits|command.cpp|std::clamp(agent(\*of).u_ref\[i\], low\[i\], high\[i\])|agent(*of).u_ref[i]'
    'rest within the limits of the start|command.cpp|of->limits->at(t, low, high)|of->limits->at(0.0, low, high)'
    'what is huge is a state|./loop.hpp|largest = 1e9;|largest = 1e10;'
    'a heading without a length is a state|run/valid_states.cpp|return body.model.normalise(scratch_.data());|return true;'
    'what is measured at no time is valid|run/valid_states.cpp|can_be_valid \&\& stamp < std::numeric_limits<double>::infinity() \&\&|can_be_valid \&\&'
    'what follows from nothing valid is valid|run/valid_states.cpp|of.valid_\[i\] != 0|true'
    'what is not valid is taken|run/valid_states.cpp|if (valid_\[i\] == 0) return;|;'
    'what is not valid is new|run/valid_states.cpp|stamps_\[i\] = stamp;|;'
    'what follows has no time|run/valid_states.cpp|take_body(i, x, of.stamps_\[i\],|take_body(i, x, 0.0,'
    'a start that is no state is taken|run/valid_states.cpp|if (admits(body, x))|if (true)'
    'a start is a measurement at time zero|run/valid_states.cpp|-std::numeric_limits<double>::infinity()|0.0'
    'the first body measured for all|run/valid_states.cpp|x.subspan(body.x, body.nx);$|x.subspan(0, body.nx);'
    'limits of the last period stay open|run/stages/command.hpp|  p.gate.open(p.t);|;'
    'limits and rates kept by solvers alone|run/stages/command.hpp|p.gate.keep_limits_and_rates(p.u, p.added);|(void)0;'
    'limits that an event narrows not in force|run/stages/team_change.cpp|  p.gate.set_limits(now.limits);|;'
  )
}

solver() {
  folder=solver/newton
  sources=(solver/newton/{active_set,descent,extrapolate,groups,krylov,line_search,linearise,newton_riccati,output,plan,prepare,update,workspace}
    solver/kernels/stage)
  tests=(solver/{riccati,krylov,descent,third_body,rate_cost,applied_inputs,extrapolate,newton_riccati,solver})
  filter='RiccatiStage.*:Krylov.*:Descent.*:ThirdBody.IsPlanned*:RateCost.*:AppliedInputs.*:AppliedInputsOfAll/0.*:Foresight.*:NewtonRiccati.ItsKkt*:NewtonRiccati.EveryStatus*:NewtonRiccati.AFlight*:NewtonRiccati.TheUnit*:NewtonRiccati.ABodyMoves*:NewtonRiccati.EachStage*:NewtonRiccati.LowerAnd*:AnySolver/2.*-AnySolver/2.RandomTeams*:AnySolver/2.Obstacles*'
  objects=(cli/allocations)
  libraries=("$build/lib/libsightline.a" "$build/lib/libsightline_core.a" -lsqlite3 -llz4 -lzstd -ltomlplusplus -lz)
  mutants=(
    'plans extrapolated twice as far|extrapolate.cpp|passed / before}|2 * passed / before}'
    'extrapolation never given up|extrapolate.cpp|if (w.votes >= 0) {|if (true) {'
    'previous inputs with what is added|prepare.cpp|w.previous\[at_u\] - w.offset\[at_u\]|w.previous[at_u]'
    'lower limits without what is added|prepare.cpp|low\[i\] -= w.offset\[input + i\], |'
    'limits of the first stage at all stages|prepare.cpp|find_limits(w, agent, input, time, k \* h)|find_limits(w, agent, input, time, 0.0)'
    'bodies stand still along the horizon|prepare.cpp|      sight.p = sight.p + h \* sight.v;|      ;'
    'references of the start|prepare.cpp|x_ref.along(time, |x_ref.along(0.0, '
    'active set outlives a start|prepare.cpp|^    w.active\[i\] = 0.0;|    ;'
    'plan outlives a start that has none|prepare.cpp|clamp(w.has_plan ? w.u\[i\] : 0.0,|clamp(w.u[i],'
    'residual of the last group|linearise.cpp|all.residual = std::max(all.residual, p.residual);|all.residual = p.residual;'
    'what is not finite is a step|linearise.cpp|largest(residual), nan == 0.0,|largest(residual), true,'
    'steps beyond limits|linearise.cpp|kept.store(w.u_next + i);|next.store(w.u_next + i);'
    'inputs below put on the upper limit|active_set.cpp|where_negative(below, low, u)|where_negative(below, high, u)'
    'active inputs never freed|active_set.cpp|const L stays = .*|const L stays = held;'
    'gain without the costs to come|solver/kernels/riccati.hpp|G(a, j) += B(q, a) \* PA(q, j);|;'
    'cost-to-go without pivots|solver/kernels/riccati.hpp|s -= Y(a, i) \* Z(a, j);|s -= Y(a, i) * Y(a, j);'
    'rate of the first input over a stage|solver/kernels/stage.cpp|(carries_on ? h_ : rates_.first)|h_'
    'barriers without the step of the horizon|solver/kernels/stage.cpp|h \* cost_of_limits|cost_of_limits'
    'damping in another unit|solver/kernels/stage.cpp|1.0 / (scale \* scale)|1.0 / scale'
    'input costs halved|groups.cpp|2.0 \* h_ \* agent.R\[at(i)\]|h_ * agent.R[at(i)]'
    'lean not planned with|groups.cpp|s\[of(k, first + 1)\] += lean.y|s[of(k, first + 1)] -= lean.y'
    'directions not conjugate|krylov.cpp|const L beta = k > 0 ? next_rho / rho : 0.0;|const L beta = 0.0;'
    'nobody visited twice|krylov.cpp|due_\[at(woken)\] = 1;|due_[at(woken)] = 0;'
    'similar steps begin anew|krylov.cpp|share_ = has_added_ \&\& .*|share_ = 0.0;'
    'costs may rise|descent.cpp|unit.settled = unit.cost < unit.before + |unit.settled = unit.cost < 2 * unit.before + '
    'limits left along a search|descent.cpp|clamp(start\[at\] + alpha \* d\[at\], low\[at\], high\[at\])|start[at] + alpha * d[at]'
    'what another feels is paid for|descent.cpp|(potential.b == a \&\& potential.ends.b_feels)|potential.b == a'
    'shortened steps are whole|update.cpp|steps == 1 \&\& step.whole |steps == 1 '
    'late updates are in time|update.cpp|step.in_time = !late(w);|step.in_time = true;'
    'inputs that are no numbers applied|update.cpp|if (!step.finite) return fall_back.*|;'
    'plan of missing states held|plan.cpp|(time - w.plan_time) / w.ocp.horizon().h()|0.0'
    'plan outlives a restart|plan.cpp|std::fill_n(w.plan, w.groups.layout().u_length, 0.0);|;'
    'predictions outlive a restart|plan.cpp|prediction.sights.clear();|;'
    'bodies predicted at rest|output.cpp|to\[i\] += k \* w.ocp.horizon().h() \* to\[3 + i\];|;'
    'inputs beyond limits where states are missing|output.cpp|clamp(w.raw_u\[to + at(i)\], w.limits\[at(i)\], w.limits\[at(nu + i)\])|w.raw_u[to + at(i)]'
  )
}

estimate() {
  folder=estimate
  sources=(estimate/{attitude_filter,broadcast_track,heading_filter,localization_graph,observability,pose_filter})
  tests=(estimate/{kalman,agreement,broadcast_track,observability,localization_graph,heading_filter,attitude_filter,out_of_sequence_filter,pose_filter,chain_filter})
  filter='*-AttitudeFilter.TheAttitudeStays*:PoseFilter.*Attitude*:PoseFilter.Slow*:PoseFilter.Outliers*:PoseFilter.ACamera*:PoseFilter.While*:PoseFilter.AWrong*:PoseFilter.PositionsThat*'
  objects=(tests/support/counting_new)
  libraries=("$build/lib/libsightline.a" "$build/lib/libsightline_core.a" -lsqlite3 -llz4 -lzstd -ltomlplusplus -lz)
  mutants=(
    'no gate|kalman.hpp|result.accepted = result.squared <= chi_squared_gate<m>;|result.accepted = true;'
    'gate of three components narrower|kalman.hpp|16.266|14.266'
    'covariance without that of the measurement|kalman.hpp|sum - RKt(a, i)|sum'
    'heading has the covariance of a position|kalman.hpp|block<1, 1>(of.R, m - 1, m - 1)|block<1, 1>(of.R, 0, 0)'
    'bias of the velocity added|heading_filter.cpp|v = motion.v_V - s.velocity_bias;|v = motion.v_V + s.velocity_bias;'
    'bias of the yaw rate kept out|heading_filter.cpp|dt \* (motion.yaw_rate - s.rate_bias)|dt * motion.yaw_rate'
    'noise of the velocity a hundred times as large|heading_filter.hpp|square(options.velocity_noise) \* share|square(options.velocity_noise) * dt'
    'error of the seen body left out|heading_filter.cpp|    R += R_VG \* block<3, 3>(z.P_other, 0, 0) \* transposed(R_VG);|'
    'second order of a turn left out|heading_filter.cpp|R += 0.5 \* square(s.P(psi_at, psi_at)) \* outer(level, level);|;'
    'unobserved turn left as it was|heading_filter.cpp|s.P(0, j) -= d.y \* s.P(psi_at, j), |'
    'turning while nothing is measured left out|heading_filter.cpp|s.P(psi_at, psi_at) += square(0.5 \* unmeasured_turning \* gap \* gap);|;'
    'error of the other renewed too slowly|heading_filter.cpp|const double fresh = 1 - square(keep);|const double fresh = 1 - keep;'
    'heading of the other of the wrong sign|heading_filter.cpp|of.H(3, other_at + 3) = -1.0;|of.H(3, other_at + 3) = 1.0;'
    'bias of the gyroscope added|attitude_filter.cpp|(motion.gyro - s.gyro_bias))|(motion.gyro + s.gyro_bias))'
    'gravity upwards|attitude_filter.cpp|s.R \* f - Vec3|s.R * f + Vec3'
    'turn of the camera on the wrong side|attitude_filter.cpp|C = mount_.attitude() \* turn(s.camera_turn)|C = turn(s.camera_turn) * mount_.attitude()'
    'headings the long way|broadcast_track.cpp|s \* wrap(b.psi - a.psi)|s * (b.psi - a.psi)'
    'cubic without the velocity at its end|broadcast_track.cpp|(h \* (s3 - s2)) \* b.v|(h * (s2 - s3)) * b.v'
    'messages carried on twice as long|broadcast_track.cpp|t - last.stamp > options_.longest|t - last.stamp > 2 * options_.longest'
    'a message counts twice|broadcast_track.cpp|if (place != end \&\& place->stamp == message.stamp) return;|;'
    'error of a message not shared|broadcast_track.cpp|std::max(1.0, interval \* options_.sighting_rate)|1.0'
    'heading held after the last message|broadcast_track.cpp|wrap(a.psi + d \* a.yaw_rate)|wrap(a.psi)'
    'error of the velocity left out after the last message|broadcast_track.cpp| + square(options_.velocity_sigma \* d)|'
    'turning after the last message left out|broadcast_track.cpp|pose.P(3, 3) += square(options_.turning \* d);|;'
    'late ones applied on arrival|out_of_sequence_filter.hpp|Fit fit = replay(slot_of(z.stamp), \&z);|Fit fit = replay(count_ - 1, \&z);'
    'one counts twice|out_of_sequence_filter.hpp|if (measured_.has(z)) return {FitVerdict::repeated};|;'
    'early ones forgotten|out_of_sequence_filter.hpp|for (const Measurement\& z : waiting) take(z);|;'
    'gaps without uncertainty|out_of_sequence_filter.hpp|gap > 1e-6)|gap > 1e6)'
    'what is older than the start taken|out_of_sequence_filter.hpp|(known_ \&\& z.stamp <= begun_)|false'
    'starts one sighting early|out_of_sequence_filter.hpp|psi, variance)) < start_)|psi, variance)) < start_ - 1)'
    'never restarts|out_of_sequence_filter.hpp|contradictions_.add(hypothesis) < restart_|contradictions_.add(hypothesis) > 0'
    'headings never restart|out_of_sequence_filter.hpp|turned_.add(hypothesis) < restart_|turned_.add(hypothesis) > 0'
    'contradictions outlive an accepted position|out_of_sequence_filter.hpp|if (z.measures_position()) contradictions_.clear();|;'
    'candidates outlive a start|out_of_sequence_filter.hpp|^  candidates_.clear();|  ;'
    'an old compass is trusted|out_of_sequence_filter.hpp|> Agreement::window) return|> 100 * Agreement::window) return'
    'last accepted goes back|out_of_sequence_filter.hpp|last_accepted_ = std::max(last_accepted_, z.stamp);|last_accepted_ = z.stamp;'
    'intersection trusts the other|out_of_sequence_filter.hpp|(1 / (1 - w)) \* z.P_other|z.P_other'
    'agreement over any time|agreement.hpp|if (between > window) return false;|;'
    'dead reckoning in its own frame|agreement.hpp|turn_z(a.psi - a.reckoned.psi)|turn_z(0.0)'
    'turn of a sighting of the wrong sign|observability.cpp|turn\[3\] = {across, -along, 0}|turn[3] = {across, along, 0}'
    'yaw of a tag of the wrong sign|observability.cpp|row\[4 \* i + 3\] = -1.0;|row[4 * i + 3] = 1.0;'
    'compass tells the height|observability.cpp|rows.add(one(i, 3));|rows.add(one(i, 2));'
    'turn about a body that is not known|observability.cpp|known \&\& what.about < 0|what.about < 0'
    'circles and chains exchanged|localization_graph.cpp|== circle_\[size(target)\] ?|!= circle_[size(target)] ?'
  )
}

fail() { echo "mutants.sh: $1" >&2; exit 2; }
compile() { c++ "${flags[@]}" "$@" -Iinclude -Isrc -I"$build/generated"; }
prepare() {
  local source
  rm -rf "$work/tests" && mkdir -p "$work/tests"
  test_objects=()
  for source in "${tests[@]/%/_test}"; do
    test_objects+=("$work/tests/${source//\//_}.o")
    compile -I. -c "tests/$source.cpp" -o "${test_objects[-1]}" || fail "tests/$source.cpp does not compile"
  done
  for source in "${objects[@]}"; do
    test_objects+=("$work/tests/${source//\//_}.o")
    compile -I. -c "$source.cpp" -o "${test_objects[-1]}" || fail "$source.cpp does not compile"
  done
}

# $1: a tree of the sources, and objects of those that need no compiling. Linked before the library,
# they stand for its own, which others of its batch may bring along. $2: a header of the tree that
# tests may include.
program() {
  local source i
  local -a of_tests=("${test_objects[@]}") compiled=("${sources[@]/%/.o}")
  for i in "${!tests[@]}"; do
    [[ -n ${2:-} ]] && grep -qF "\"sightline/$2\"" "tests/${tests[i]}_test.cpp" || continue
    of_tests[i]=$1/test_$i.o
    compile -I"$1" -I. -c "tests/${tests[i]}_test.cpp" -o "${of_tests[i]}" || return 1
  done
  for source in "${sources[@]}"; do
    [[ -f $1/sightline/$source.o ]] || compile -MMD -I"$1" -c "$1/sightline/$source.cpp" -o "$1/sightline/$source.o" || return 1
  done
  c++ -Wl,--allow-multiple-definition "${compiled[@]/#/$1/sightline/}" "${of_tests[@]}" "${libraries[@]}" \
    -lgtest_main -lgmock -lgtest -lfmt -lpthread -o "$1/tests" || return 1
}

# The mutant of $1 in the tree $2; `header` is the one that it changes.
mutate() {
  local name file from to user from_folder
  header=
  IFS='|' read -r name file from to <<<"$1"
  [[ $file == */* ]] || file=$folder/$file
  from_folder=src/sightline
  [[ $file != ./* ]] || from_folder=include/sightline file=${file#./}  # a public header
  mkdir -p "$(dirname "$2/sightline/$file")"
  rm -f "$2/sightline/${file%.*}.o" "$2/tests"
  sed "s|$from|$to|" "$from_folder/$file" >"$2/sightline/$file"
  cmp -s "$2/sightline/$file" "$from_folder/$file" && fail "mutant \"$name\" changes nothing, expected \"$from\" in $file"
  [[ $file == *.hpp ]] || return 0
  header=$file  # whoever includes it is compiled again
  for user in "${sources[@]}"; do
    if [[ ! -f $2/sightline/$user.d ]] || grep -qF "sightline/$file" "$2/sightline/$user.d"; then rm -f "$2/sightline/$user.o"; fi
  done
}

run_group() {
  local mutant name source tree header
  count=$((count + ${#mutants[@]}))
  if [[ -n $check ]]; then
    for mutant in "${mutants[@]}"; do mutate "$mutant" "$work/mutant"; done
    return
  fi
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
    if ! program "$tree" "$header" 2>"$work/log"; then
      cat "$work/log" >&2
      echo "NO BUILD  $name"
      survivors=$((survivors + 1))
    elif timeout 300 "$tree/tests" --gtest_filter="$filter" --gtest_fail_fast >"$work/log" 2>&1; then
      echo "SURVIVED  $name"
      survivors=$((survivors + 1))
    else
      echo "killed    $name: $(sed -nE 's/^\[  FAILED  \] ([A-Za-z0-9.\/]+).*/\1/p' "$work/log" | head -1)"
    fi
  done
}

begin=$SECONDS
count=0
survivors=0
for group in "${groups[@]}"; do
  declare -F "$group" >/dev/null || fail "group $group = not known, expected barrier, verdicts, gate, solver or estimate"
  "$group"
  run_group "$group"
done
[[ -z $check ]] || { echo "$count mutants, each changes its file"; exit 0; }
echo "$count mutants, $survivors survived or did not build, $((SECONDS - begin)) s"
((survivors == 0))
