#include "sightline/judge/input_record.hpp"

#include <cmath>
#include <span>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr double input_tolerance = 1e-9;  // tolerated excess over a limit

// False for NaN.
bool is_within(double u, double low, double high) {
  return u >= low - input_tolerance && u <= high + input_tolerance;
}

}  // namespace

bool all_finite(const Sample& sample) noexcept {
  return all_finite(sample.x) &&
         (sample.of == Sample::Of::states || (all_finite(sample.u) && all_finite(sample.raw_u)));
}

InputRecord::InputRecord(const Scenario& scenario)
    : period_(scenario.horizon.dt), chatter_(size(scenario.team.nu())) {
  const Team& team = scenario.team;
  std::size_t nu_most = 0;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (!team.is_agent(body)) continue;
    const std::size_t nu = size(team.model(body).nu());
    robots_.push_back({body, size(team.input_offset(body)), nu});
    robots_.back().before.resize(nu);
    nu_most = std::max(nu_most, nu);
  }
  u_min_.resize(nu_most);
  u_max_.resize(nu_most);
}

void InputRecord::add_states(const Sample& sample, const PresentTeam& present) noexcept {
  beyond_ += std::exchange(held_beyond_, 0);
  for (const Robot& robot : robots_) {
    if (sample.presence[at(robot.body)] == Presence::absent) continue;
    const std::span<double> low = std::span(u_min_).first(robot.nu), high = std::span(u_max_).first(robot.nu);
    present.limits(robot.body).at(sample.time, low, high);
    for (std::size_t i = 0; i < robot.nu; ++i)
      held_beyond_ += is_within(sample.u[robot.u + i], low[i], high[i]) ? 0 : 1;
  }
}

void InputRecord::add(const Sample& sample, const PresentTeam& present) noexcept {
  within_ = true;
  beyond_ += std::exchange(held_beyond_, 0);
  for (Robot& robot : robots_) {
    if (sample.presence[at(robot.body)] == Presence::absent) continue;
    add_limits(robot, sample, present.limits(robot.body));
    if (const Agent* const steered = present.agent(robot.body)) add_costs(robot, sample, *steered);
  }
}

void InputRecord::add_limits(const Robot& robot, const Sample& sample, const InputLimits& limits) noexcept {
  const std::span<double> low = std::span(u_min_).first(robot.nu), high = std::span(u_max_).first(robot.nu);
  limits.at(sample.time, low, high);
  for (std::size_t i = 0; i < robot.nu; ++i) {
    const auto beyond = [&](double u) { return !is_within(u, low[i], high[i]); };
    const std::size_t k = robot.u + i;
    const double u = sample.u[k], raw = sample.raw_u[k];
    largest_raw_ = std::max(largest_raw_, std::abs(raw));
    raw_beyond_ += beyond(raw) ? 1 : 0;
    beyond_ += beyond(u) ? 1 : 0;
    within_ = within_ && !beyond(u);
    chatter_.add(k, sample.time, u, high[i] - low[i]);
  }
}

void InputRecord::add_costs(Robot& robot, const Sample& sample, const Agent& agent) noexcept {
  const std::span<const double> u = std::span(sample.u).subspan(robot.u, robot.nu);
  for (std::size_t i = 0; i < robot.nu; ++i) robot.energy += period_ * agent.R[i] * u[i] * u[i];
  for (std::size_t i = 0; i < agent.rate_max.size() && robot.has_before; ++i) {
    const double rate = std::abs(u[i] - robot.before[i]) / (sample.time - robot.time_before);
    robot.rate_ratio = std::max(robot.rate_ratio, rate / agent.rate_max[i]);
  }
  std::copy(u.begin(), u.end(), robot.before.begin());
  robot.time_before = sample.time;
  robot.has_before = true;
}

double InputRecord::energy() const noexcept {
  double sum = 0.0;
  for (const Robot& robot : robots_) sum += robot.energy;
  return sum;
}

}  // namespace sightline
