#include "sightline/judge/run_evaluator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {

std::string_view to_string(Outcome outcome) {
  constexpr std::array<std::string_view, outcome_count> names = {"recovered", "lost", "too_close", "failed"};
  return names[static_cast<std::size_t>(outcome)];
}

RunEvaluator::RunEvaluator(const Scenario& scenario, const CampaignPlan& plan, Sample sample)
    : team_(scenario.team),
      plan_(plan),
      period_(scenario.horizon.dt),
      hold_after_(hold_after(scenario)),
      safety_(scenario, plan.d_hard, plan.start_outside),
      localization_(scenario),
      changes_(changes_in_flight(scenario)),
      present_(scenario),
      sample_(std::move(sample)),
      inputs_(scenario),
      drift_(scenario.team, scenario.simulation.settle),
      gaps_(sample_.solvers.size()) {
  const std::vector<Coupling> couplings = changes_ ? all_couplings(scenario) : team_.couplings();
  for (const Observation& pair : observations(couplings))
    views_.push_back(
        {.pair = pair,
         .requested = !changes_,
         .recent = std::vector<double>(
             static_cast<std::size_t>(std::llround(view_lost_after / scenario.horizon.dt)) + 1)});
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    if (!team_.is_agent(body)) continue;
    const Agent& agent = team_.agent(body);
    robots_.push_back({body, TrackingError(agent.model, scenario.simulation.rms_from)});
    u_rest_.insert(u_rest_.end(), agent.u_ref.begin(), agent.u_ref.end());
  }
  sights_.resize(static_cast<std::size_t>(team_.bodies()));
}

/// Follows the bodies and couplings in force from this sample on. @return whether they changed
bool RunEvaluator::follow() {
  const bool changed = present_.follow(sample_);
  if (!changes_ || (!changed && updates_ > 0)) return false;
  const std::vector<Coupling> couplings = present_.couplings();
  if (changed) drift_.restart(couplings);
  const std::vector<Observation> requested = observations(couplings);
  for (View& view : views_) {
    const bool now = std::any_of(requested.begin(), requested.end(),
                                 [&](const Observation& one) { return is_same_view(one, view.pair); });
    // Who was not given the time to see it is not blamed.
    if (view.requested && !now && (view.first < never || sample_.time - view.since > plan_.view_within))
      view.waited = view.wait();
    if (now && !view.requested) view.since = sample_.time, view.first = view.last = never, view.count = 0;
    view.requested = now;
  }
  return true;
}

void RunEvaluator::look() noexcept {
  for (int i = 0; i < team_.bodies(); ++i) sights_[at(BodyId{i})] = true_sight(team_, BodyId{i}, sample_);
}

void RunEvaluator::look_at(View& view) noexcept {
  const auto sight = [&](BodyId body) { return sights_[at(body)]; };
  const Sight<double> observer = first_sight(sight, view.pair.observer, view.pair.third);
  const double limit = view.pair.potential.violation(observer, sights_[at(view.pair.target)], sample_.time);
  view.seen = limit <= 0;
  if (view.seen) view.first = std::min(view.first, sample_.time), view.last = sample_.time;
  result_.longest_out_of_view = std::max(result_.longest_out_of_view, sample_.time - view.last);
  // A target that is not seen in time counts from then on.
  if (view.first == never && sample_.time - view.since <= plan_.view_within) return;
  view.recent[view.count++ % view.recent.size()] = limit;
  if (view.count < view.recent.size()) return;
  view_margin_ = std::min(view_margin_, -*std::min_element(view.recent.begin(), view.recent.end()));
}

void RunEvaluator::publish() noexcept {
  if (failure_) return;
  try {
    judge();
  } catch (...) {
    failure_ = std::current_exception();
  }
}

void RunEvaluator::judge() {
  const bool is_update = sample_.of == Sample::Of::update, changed = is_update && follow();
  if (updates_ == 0) {
    sample_.u.swap(u_rest_);  // before any input
    look();
    sample_.u.swap(u_rest_);
    safety_.look_at_brakes(sights_, sample_.presence, plan_.braking);
  }
  look();
  if (changed) safety_.look_at_brakes(sights_, sample_.presence, plan_.braking);
  safety_.add(sample_, sights_);
  const bool apart = !safety_.too_close_now();
  const bool finite = all_finite(sample_);
  drift_.add(sample_, sights_, present_);
  if (!is_update) {
    if (!finite) blame(Fault::not_finite);
    if (!apart) ++result_.violations;
    return;
  }
  ++updates_;
  inputs_.add(sample_, present_);
  const bool good = finite && inputs_.within();
  if (!good) blame(finite ? Fault::input : Fault::not_finite);
  localization_.add(sample_);
  for (std::size_t i = 0; i < sample_.levels.size(); ++i)
    result_.landed =
        result_.landed || (sample_.levels[i] >= FallbackLevel::land &&
                           sample_.presence[i] != Presence::land && sample_.presence[i] != Presence::absent);
  for (Robot& robot : robots_)
    if (const Agent* const steered = present_.agent(robot.body))
      robot.error.add(*steered, sample_.time, sights_[at(robot.body)]);
  if (!good || !apart) ++result_.violations;

  bool any_requested = false, all_seen = true;
  for (View& view : views_) {
    if (!view.requested) continue;
    any_requested = true;
    look_at(view);
    all_seen = all_seen && view.seen;
  }
  if (any_requested && all_seen) ++seen_;
  for (std::size_t c = 0; c < gaps_.size(); ++c) {
    const SolverRecord& record = sample_.solvers[c];
    gaps_[c].add(sample_.time, period_, record);
    ++result_.statuses[static_cast<std::size_t>(record.status)];
    if (gaps_[c].failed().longest > hold_after_ + same_time) blame(Fault::no_plan);
  }
}

void RunEvaluator::blame(Fault fault) noexcept {
  if (fault_ != Fault::none) return;
  fault_ = fault;
  fault_time_ = sample_.time;
}

std::string RunEvaluator::reason(std::string ended, bool whole) const {
  if (!ended.empty()) return ended;
  switch (fault_) {
    case Fault::not_finite:
      return fmt::format("a state or an input was not finite at {:.2f} s", fault_time_);
    case Fault::input:
      return fmt::format("an applied input was beyond its limit at {:.2f} s", fault_time_);
    case Fault::no_plan:
      return fmt::format("a solver gave no plan for longer than {} s, at {:.2f} s", hold_after_, fault_time_);
    case Fault::none:
      break;
  }
  const std::vector<std::string> walls = safety_.broken_walls();
  if (!walls.empty()) return walls.front();
  return whole ? "" : "the run broke off";
}

RunResult RunEvaluator::result(const LoopOutcome& outcome, std::string ended) const {
  if (failure_) std::rethrow_exception(failure_);
  RunResult result = result_;
  const auto periods = std::llround(plan_.duration / period_);
  const double least = safety_.least_distance();
  result.min_distance = std::isfinite(least) ? least : no_value;
  result.could_brake = safety_.could_brake();
  double first = views_.empty() ? no_value : 0.0;
  bool at_end = true;
  for (const View& view : views_) {
    first = std::max(first, view.wait());
    at_end = at_end && (view.seen || !view.requested);
  }
  const bool in_time = views_.empty() || first <= plan_.view_within;
  result.time_to_first_view = std::isfinite(first) ? first : no_value;
  result.fraction_in_view =
      views_.empty() || updates_ == 0 ? no_value : static_cast<double>(seen_) / static_cast<double>(updates_);
  result.energy = inputs_.energy();
  for (std::size_t i = 0; i < robots_.size(); ++i)
    result.robots.push_back(
        {inputs_.robots()[i].energy, robots_[i].error.rms_position(), robots_[i].error.rms_heading()});
  result.chatter = inputs_.chatter().worst_share();
  const auto drift = drift_.found();
  result.drift = !drift ? no_value : drift->empty() ? 0.0 : norm(drift->front().v);
  for (const PlanGaps& gaps : gaps_)
    result.longest_without_plan = std::max(result.longest_without_plan, gaps.any().longest);
  result.barrier_conflict = safety_.conflict_share();
  result.view_margin = std::isfinite(view_margin_) ? view_margin_ : no_value;
  result.distance_margin = safety_.distance_margin();
  result.localizations = localization_.robots();
  result.views = safety_.views();
  result.reason = reason(std::move(ended), outcome.finite && updates_ == periods);
  result.outcome = !result.reason.empty() ? Outcome::failed
                   : safety_.too_close()  ? Outcome::too_close
                   : !(in_time && at_end) ? Outcome::lost
                                          : Outcome::recovered;
  return result;
}

}  // namespace sightline
