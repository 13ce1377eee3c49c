#include "sightline/campaign/judge.hpp"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double same_distance = 1e-9;  // [m]

std::size_t at(BodyId body) { return static_cast<std::size_t>(body.index); }

}  // namespace

std::string_view to_string(Outcome outcome) {
  constexpr std::array<std::string_view, outcome_count> names = {"recovered", "lost", "too_close", "failed"};
  return names[static_cast<std::size_t>(outcome)];
}

Judge::Judge(const Scenario& scenario, const CampaignPlan& plan, Sample sample)
    : team_(scenario.team), plan_(plan), period_(scenario.horizon.dt), sample_(std::move(sample)) {
  for (const Observation& pair : observations(team_)) views_.push_back({pair});
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    if (!team_.is_agent(body)) continue;
    robots_.push_back(body);
    const Agent& agent = team_.agent(body);
    u_rest_.insert(u_rest_.end(), agent.u_ref.begin(), agent.u_ref.end());
    for (int j = 0; j < team_.bodies(); ++j) {
      // Two robots once; a robot and what is not controlled, whichever stands first.
      const BodyId other{j};
      if (other != body && !(team_.is_agent(other) && j < i)) pairs_.emplace_back(body, other);
    }
  }
  sights_.resize(static_cast<std::size_t>(team_.bodies()));
  u_min_.resize(u_rest_.size());
  u_max_.resize(u_rest_.size());
  result_.min_distance = std::numeric_limits<double>::infinity();
}

void Judge::look(std::span<const double> u) noexcept {
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    sights_[at(body)] = team_.model(body).sight(sample_.x.data() + team_.state_offset(body),
                                                u.data() + team_.input_offset(body));
  }
}

double Judge::least_distance() const noexcept {
  double least2 = std::numeric_limits<double>::infinity();
  for (const auto& [robot, other] : pairs_) {
    const Vec3<double> r = sights_[at(robot)].p - sights_[at(other)].p;
    least2 = std::min(least2, dot(r, r));
  }
  return std::sqrt(least2);
}

/// Whether each two are so far apart that their closing speed can be braked away before d_hard.
bool Judge::can_brake() const noexcept {
  return std::all_of(pairs_.begin(), pairs_.end(), [&](const auto& pair) {
    const Sight<double>&a = sights_[at(pair.first)], &b = sights_[at(pair.second)];
    const Vec3<double> r = a.p - b.p;
    const double distance = norm(r);
    const double closing = distance > 0 ? std::max(0.0, -dot(r, a.v - b.v) / distance) : 0.0;
    return distance >= plan_.d_hard + closing * closing / (2 * plan_.braking);
  });
}

bool Judge::inputs_hold() noexcept {
  for (const BodyId robot : robots_) {
    const Agent& agent = team_.agent(robot);
    const std::size_t nu = agent.R.size();
    const double* u = sample_.u.data() + team_.input_offset(robot);
    const auto low = std::span(u_min_).first(nu), high = std::span(u_max_).first(nu);
    agent.limits.at(sample_.time, low, high);
    for (std::size_t i = 0; i < nu; ++i) {
      if (!(u[i] >= low[i] && u[i] <= high[i])) return false;  // nor what is not a number
      result_.energy += period_ * agent.R[i] * u[i] * u[i];
    }
  }
  return true;
}

void Judge::publish() noexcept {
  if (updates_ == 0 && plan_.d_hard > 0) {
    look(u_rest_);
    result_.could_brake = can_brake();
  }
  ++updates_;
  look(sample_.u);
  const bool good = inputs_hold() && all_finite(sample_.x);
  sound_ = sound_ && good;
  const double distance = least_distance();
  result_.min_distance = std::min(result_.min_distance, distance);
  const bool near = plan_.d_hard > 0 && result_.could_brake && distance < plan_.d_hard - same_distance;
  if (!good || near) ++result_.violations;

  bool all_seen = !views_.empty();
  for (View& view : views_) {
    const Sight<double>&observer = sights_[at(view.pair.observer)], &target = sights_[at(view.pair.target)];
    view.seen = view.pair.potential.violation(observer, target, sample_.time) <= 0;
    if (view.seen) view.first = std::min(view.first, sample_.time);
    all_seen = all_seen && view.seen;
  }
  if (all_seen) ++seen_;
  for (const SolverRecord& record : sample_.solvers)
    ++result_.statuses[static_cast<std::size_t>(record.status)];
}

RunResult Judge::result(const LoopOutcome& outcome) const {
  RunResult result = result_;
  const auto periods = std::llround(plan_.duration / period_);
  if (!std::isfinite(result.min_distance)) result.min_distance = none;
  double first = views_.empty() ? none : 0.0;
  bool at_end = true;
  for (const View& view : views_) {
    first = std::max(first, view.first);
    at_end = at_end && view.seen;
  }
  const bool in_time = views_.empty() || first <= plan_.view_within;
  result.time_to_first_view = std::isfinite(first) ? first : none;
  result.fraction_in_view =
      views_.empty() || updates_ == 0 ? none : static_cast<double>(seen_) / static_cast<double>(updates_);
  const bool too_close =
      plan_.d_hard > 0 && result.could_brake && result.min_distance < plan_.d_hard - same_distance;
  result.outcome = !sound_ || !outcome.finite || updates_ != periods ? Outcome::failed
                   : too_close                                       ? Outcome::too_close
                   : !(in_time && at_end)                            ? Outcome::lost
                                                                     : Outcome::recovered;
  return result;
}

}  // namespace sightline
