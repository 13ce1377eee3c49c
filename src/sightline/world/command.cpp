#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

// Tolerance relative to a limit: an input plus its offset may exceed the limit by rounding.
constexpr double rounding = 1e-9;

bool is_beyond(double u, double low, double high) noexcept {
  return u < low - rounding * (1 + std::abs(low)) || u > high + rounding * (1 + std::abs(high));
}

}  // namespace

CommandGate::CommandGate(const Team& team, double period)
    : team_(team), period_(period), u_min_(size(team.nu())), u_max_(u_min_), applied_(u_min_) {
  for (int b = 0; b < team_.bodies(); ++b) {
    const BodyId body{b};
    if (!team_.is_agent(body)) continue;
    const Agent& agent = team_.agent(body);
    robots_.push_back({body, size(team_.input_offset(body)), agent.u_ref.size(), &agent.limits});
  }
  replaced_.reserve(robots_.size());
  for (const Robot& robot : robots_) rest(robot.body, 0.0, applied_);
  open(0.0);
}

void CommandGate::set_limits(std::span<const InputLimits> limits) noexcept {
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i].limits = &limits[i];
}

void CommandGate::open(double t) noexcept {
  for (const Robot& robot : robots_) {
    robot.limits->at(t, std::span(u_min_).subspan(robot.u, robot.nu),
                     std::span(u_max_).subspan(robot.u, robot.nu));
  }
}

void CommandGate::keep_limits_and_rates(std::span<double> u, std::span<const double> added) const noexcept {
  for (const Robot& robot : robots_) {
    const std::vector<double>& rate_max = agent(robot).rate_max;
    for (std::size_t i = 0; i < robot.nu; ++i) {
      const std::size_t k = robot.u + i;
      double low = u_min_[k], high = u_max_[k];
      if (!rate_max.empty()) {
        const double most = rate_max[i] * period_;
        const double slow_low = std::clamp(applied_[k] - most, low, high),
                     slow_high = std::clamp(applied_[k] + most, low, high);
        low = slow_low, high = slow_high;
      }
      const double by = added.empty() ? 0.0 : added[k];
      u[k] = std::clamp(u[k], low - by, high - by);
    }
  }
}

Command CommandGate::pass(std::span<const double> u, std::span<const double> added) noexcept {
  replaced_.clear();
  for (const Robot& robot : robots_) {
    bool is_finite = true, is_within = true;
    const auto sum = [&](std::size_t k) { return added.empty() ? u[k] : u[k] + added[k]; };
    for (std::size_t k = robot.u; k < robot.u + robot.nu; ++k) {
      is_finite = is_finite && std::isfinite(sum(k));
      is_within = is_within && !is_beyond(sum(k), u_min_[k], u_max_[k]);
    }
    for (std::size_t k = robot.u; k < robot.u + robot.nu; ++k)
      applied_[k] = std::clamp(is_finite ? sum(k) : applied_[k], u_min_[k], u_max_[k]);
    if (!is_finite || !is_within) replaced_.push_back(robot.body);
  }
  return Command(applied_);
}

void CommandGate::rest(BodyId robot, double t, std::span<double> u) noexcept {
  const auto of =
      std::find_if(robots_.begin(), robots_.end(), [robot](const Robot& one) { return one.body == robot; });
  if (of == robots_.end()) return;
  const std::span<double> low = std::span(u_min_).subspan(of->u, of->nu),
                          high = std::span(u_max_).subspan(of->u, of->nu);
  of->limits->at(t, low, high);
  for (std::size_t i = 0; i < of->nu; ++i) u[of->u + i] = std::clamp(agent(*of).u_ref[i], low[i], high[i]);
}

}  // namespace sightline
