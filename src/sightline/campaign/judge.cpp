#include "sightline/campaign/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/base/no_value.hpp"
#include "sightline/base/same_time.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {}  // namespace

std::string_view to_string(Outcome outcome) {
  constexpr std::array<std::string_view, outcome_count> names = {"recovered", "lost", "too_close", "failed"};
  return names[static_cast<std::size_t>(outcome)];
}

Judge::Judge(const Scenario& scenario, const CampaignPlan& plan, Sample sample)
    : team_(scenario.team),
      plan_(plan),
      period_(scenario.horizon.dt),
      hold_after_(hold_after(scenario)),
      safety_(scenario, plan.d_hard, plan.start_outside),
      localization_(scenario),
      sample_(std::move(sample)),
      chatter_(static_cast<std::size_t>(scenario.team.nu())),
      drift_(scenario.team, scenario.simulation.settle),
      agents_(static_cast<std::size_t>(scenario.team.bodies())),
      gaps_(sample_.solvers.size()) {
  const bool changes = changes_in_flight(scenario);
  if (changes) present_.emplace(scenario);
  const std::vector<Coupling> couplings = changes ? all_couplings(scenario) : team_.couplings();
  for (const Observation& pair : observations(couplings)) views_.push_back({.pair = pair, .asked = !changes});
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    if (!team_.is_agent(body)) continue;
    robots_.push_back(body);
    const Agent& agent = team_.agent(body);
    agents_[at(body)] = &agent;
    u_rest_.insert(u_rest_.end(), agent.u_ref.begin(), agent.u_ref.end());
  }
  result_.energies.resize(robots_.size(), 0.0);
  sights_.resize(static_cast<std::size_t>(team_.bodies()));
  u_min_.resize(u_rest_.size());
  u_max_.resize(u_rest_.size());
}

/// What is asked of whom from this sample on. @return whether it is something else than before
bool Judge::follow() {
  if (!present_ || (!present_->follow(sample_) && updates_ > 0)) return false;
  const std::vector<Observation> asked = observations(present_->couplings());
  for (View& view : views_) {
    const bool now = std::any_of(asked.begin(), asked.end(), [&](const Observation& one) {
      return one.observer == view.pair.observer && one.target == view.pair.target;
    });
    // Who was not given the time to see it is not blamed.
    if (view.asked && !now && (view.first < never || sample_.time - view.since > plan_.view_within))
      view.waited = view.wait();
    if (now && !view.asked) view.since = sample_.time, view.first = view.last = never;
    view.asked = now;
  }
  for (const BodyId robot : robots_) agents_[at(robot)] = present_->agent(robot);
  return true;
}

void Judge::look(std::span<const double> u) noexcept {
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    Sight<double>& seen = sights_[at(body)];
    seen = team_.model(body).sight(sample_.x.data() + team_.state_offset(body),
                                   u.data() + team_.input_offset(body));
    seen.lean = true_lean(seen.lean, body, sample_);
  }
}

bool Judge::inputs_hold() noexcept {
  for (std::size_t r = 0; r < robots_.size(); ++r) {
    const BodyId robot = robots_[r];
    if (!is_there(robot)) continue;
    const Agent& agent = team_.agent(robot);
    const std::size_t nu = agent.R.size();
    const double* u = sample_.u.data() + team_.input_offset(robot);
    const auto low = std::span(u_min_).first(nu), high = std::span(u_max_).first(nu);
    (present_ ? present_->limits(robot) : agent.limits).at(sample_.time, low, high);
    for (std::size_t i = 0; i < nu; ++i) {
      if (!(u[i] >= low[i] && u[i] <= high[i])) return false;  // nor what is not a number
      const double energy = period_ * agent.R[i] * u[i] * u[i];
      result_.energy += energy;
      result_.energies[r] += energy;
      chatter_.add(static_cast<std::size_t>(team_.input_offset(robot)) + i, sample_.time, u[i],
                   high[i] - low[i]);
    }
  }
  return true;
}

void Judge::publish() noexcept {
  if (failure_) return;
  try {
    judge();
  } catch (...) {
    failure_ = std::current_exception();
  }
}

void Judge::judge() {
  const bool is_update = sample_.of == Sample::Of::update, changed = is_update && follow();
  if (updates_ == 0) {
    look(u_rest_);
    safety_.look_at_brakes(sights_, sample_.presence, plan_.braking);
  }
  look(sample_.u);
  if (changed) safety_.look_at_brakes(sights_, sample_.presence, plan_.braking);
  safety_.add(sample_, sights_);
  const bool apart = !safety_.too_close_now();
  if (!is_update) {
    if (!all_finite(sample_.x)) blame(Fault::not_finite);
    if (!apart) ++result_.violations;
    return;
  }
  ++updates_;
  const bool in_limits = inputs_hold(), finite = all_finite(sample_.x) && all_finite(sample_.u);
  const bool good = in_limits && finite;
  if (!good) blame(finite ? Fault::input : Fault::not_finite);
  localization_.add(sample_);
  if (!good || !apart) ++result_.violations;

  bool any_asked = false, all_seen = true;
  for (View& view : views_) {
    if (!view.asked) continue;
    any_asked = true;
    const auto sight = [&](BodyId body) { return sights_[at(body)]; };
    const Sight<double> observer = first_sight(sight, view.pair.observer, view.pair.third);
    const Sight<double>& target = sights_[at(view.pair.target)];
    view.seen = view.pair.potential.violation(observer, target, sample_.time) <= 0;
    if (view.seen) view.first = std::min(view.first, sample_.time), view.last = sample_.time;
    result_.longest_out_of_view = std::max(result_.longest_out_of_view, sample_.time - view.last);
    all_seen = all_seen && view.seen;
  }
  if (any_asked && all_seen) ++seen_;
  if (drift_.due(sample_.time)) drift_.mark(sample_.time, sights_, sample_.presence, agents_);
  for (std::size_t c = 0; c < gaps_.size(); ++c) {
    const SolverRecord& record = sample_.solvers[c];
    gaps_[c].add(sample_.time, period_, record);
    ++result_.statuses[static_cast<std::size_t>(record.status)];
    if (gaps_[c].failed().longest > hold_after_ + same_time) blame(Fault::no_plan);
  }
}

void Judge::blame(Fault fault) noexcept {
  if (fault_ != Fault::none) return;
  fault_ = fault;
  fault_time_ = sample_.time;
}

std::string Judge::reason(std::string ended, bool whole) const {
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

RunResult Judge::result(const LoopOutcome& outcome, std::string ended) const {
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
    at_end = at_end && (view.seen || !view.asked);
  }
  const bool in_time = views_.empty() || first <= plan_.view_within;
  result.time_to_first_view = std::isfinite(first) ? first : no_value;
  result.fraction_in_view =
      views_.empty() || updates_ == 0 ? no_value : static_cast<double>(seen_) / static_cast<double>(updates_);
  result.chatter = chatter_.worst_share();
  const auto drift = drift_.found();
  result.drift = !drift ? no_value : drift->empty() ? 0.0 : norm(drift->front().v);
  for (const PlanGaps& gaps : gaps_)
    result.longest_without_plan = std::max(result.longest_without_plan, gaps.any().longest);
  result.barrier_conflict = safety_.conflict_share();
  result.localizations = localization_.robots();
  result.reason = reason(std::move(ended), outcome.finite && updates_ == periods);
  result.outcome = !result.reason.empty() ? Outcome::failed
                   : safety_.too_close()  ? Outcome::too_close
                   : !(in_time && at_end) ? Outcome::lost
                                          : Outcome::recovered;
  return result;
}

}  // namespace sightline
