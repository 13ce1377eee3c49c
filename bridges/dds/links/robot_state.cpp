#include "bridges/dds/links/robot_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"

namespace sightline::dds {
namespace {

/// The point nearest to `to` within distance `most` of `from`.
Vec3<double> near(const Vec3<double>& to, const Vec3<double>& from, double most) noexcept {
  const Vec3<double> way = to - from;
  const double length = norm(way);
  return length > most ? from + (most / length) * way : to;
}

/// The heading nearest to `to` within angle `most` of `from` [rad].
Vec2<double> near(const Vec2<double>& to, const Vec2<double>& from, double most) noexcept {
  const Vec2<double> between = rotate<double>({from.x, -from.y}, to);
  const double turn = std::clamp(std::atan2(between.y, between.x), -most, most);
  return rotate<double>(from, {std::cos(turn), std::sin(turn)});
}

}  // namespace

RobotState::RobotState(const Model& model)
    : model_(model),
      roles_(roles_of(model)),
      rest_(size(model.nu())),
      scratch_(size(model.nx())),
      rates_(scratch_),
      faster_(scratch_),
      lead_(scratch_) {
  std::vector<int> unmeasured = roles_.others;
  for (const int state : roles_.tilt)
    if (state >= 0) unmeasured.push_back(state);
  if (unmeasured.empty()) return;
  const std::size_t first = size(*std::min_element(unmeasured.begin(), unmeasured.end()));
  throw std::invalid_argument(
      fmt::format("the state {} of the robot {} is not measured, expected position, heading, "
                  "velocities and the rate of the heading",
                  model.states().size() > first ? model.states()[first] : "?", model.name()));
}

void RobotState::write(const Motion& motion, double* x) noexcept {
  const auto set = [&](int state, double value) {
    if (state >= 0) x[state] = value;
  };
  const Vec2<double> d = heading(rotation(motion.q));
  set(roles_.position[0], motion.p.x), set(roles_.position[1], motion.p.y),
      set(roles_.position[2], motion.p.z);
  set(roles_.direction[0], d.x), set(roles_.direction[1], d.y);
  set(roles_.angle, std::atan2(d.y, d.x));
  set(roles_.rate, motion.r);
  for (const int state : roles_.velocities) x[state] = 0.0;
  // Projects the velocity onto each velocity state's direction of motion; these directions are
  // orthogonal.
  const Vec3<double> still = model_.sight(x, rest_.data()).v;
  std::copy_n(x, scratch_.size(), scratch_.begin());
  for (const int state : roles_.velocities) {
    scratch_[size(state)] = 1.0;
    const Vec3<double> along = model_.sight(scratch_.data(), rest_.data()).v - still;
    scratch_[size(state)] = 0.0;
    const double length = dot(along, along);
    x[state] = length > 0 ? dot(along, motion.v - still) / length : 0.0;
  }
}

double RobotState::heading_rate(const double* x, const double* u) noexcept {
  model_.f(x, u, rates_.data());
  if (roles_.angle >= 0) return rates_[size(roles_.angle)];
  if (roles_.direction[0] < 0) return 0.0;
  const int i = roles_.direction[0], j = roles_.direction[1];
  return x[i] * rates_[size(j)] - x[j] * rates_[size(i)];
}

Command RobotState::command(const double* x, const double* u, double period) noexcept {
  std::copy_n(x, scratch_.size(), scratch_.begin());
  model_.step(scratch_.data(), u, ahead);
  Command command = {.d = model_.sight(scratch_.data(), u).d, .r = heading_rate(scratch_.data(), u)};
  command.v_end = end_velocity(x, u);
  command.lead = lead(x, u, period);
  std::copy_n(u, std::min(command.u.size(), rest_.size()), command.u.begin());
  return command;
}

TrajectoryPoint RobotState::lead(const double* x, const double* u, double period) noexcept {
  if (!leads_) std::copy_n(x, lead_.size(), lead_.begin());
  leads_ = true;
  model_.step(lead_.data(), u, period);
  if (!model_.normalise(lead_.data())) std::copy_n(x, lead_.size(), lead_.begin());
  const Motion robot = motion(x, u), ran = motion(lead_.data(), u);
  const Vec2<double> ran_d = heading(rotation(ran.q)), d = near(ran_d, heading(rotation(robot.q)), lead_d);
  // If the heading is limited, the velocity turns with it.
  const Vec2<double> back = rotate<double>({ran_d.x, -ran_d.y}, d),
                     v = rotate<double>(back, {ran.v.x, ran.v.y});
  write({near(ran.p, robot.p, lead_p), upright(d), near({v.x, v.y, ran.v.z}, robot.v, lead_v), ran.r},
        lead_.data());

  // Velocities at three times give acceleration and jerk by one-sided differences.
  const Sight<double> now = model_.sight(lead_.data(), u);
  const auto later = [&](double t) {
    std::copy(lead_.begin(), lead_.end(), scratch_.begin());
    model_.step(scratch_.data(), u, t);
    return model_.sight(scratch_.data(), u).v;
  };
  const Vec3<double> v_1 = later(ahead / 2), v_2 = later(ahead);
  constexpr double h = ahead / 2;
  return {.p = now.p,
          .v = now.v,
          .a = (1 / (2 * h)) * (4.0 * v_1 - 3.0 * now.v - v_2),
          .j = (1 / (h * h)) * (v_2 - 2.0 * v_1 + now.v),
          .d = now.d,
          .r = heading_rate(lead_.data(), u)};
}

// Steady state of s' = alpha (s - s_end) for each velocity state s; alpha is the change of s' per 1
// m/s.
Vec3<double> RobotState::end_velocity(const double* x, const double* u) noexcept {
  constexpr double slowest = -0.01;  // alpha of the slowest state with a steady state [1/s]
  std::copy_n(x, scratch_.size(), scratch_.begin());
  model_.f(x, u, rates_.data());
  for (const int state : roles_.velocities) {
    const std::size_t i = size(state);
    scratch_[i] += 1.0;
    model_.f(scratch_.data(), u, faster_.data());
    scratch_[i] = x[state];
    const double alpha = faster_[i] - rates_[i];
    scratch_[i] = alpha < slowest ? x[state] - rates_[i] / alpha : x[state] + ahead * rates_[i];
  }
  return model_.sight(scratch_.data(), u).v;
}

Motion RobotState::motion(const double* x, const double* u) noexcept {
  const Sight<double> seen = model_.sight(x, u);
  return {seen.p, upright(seen.d), seen.v, heading_rate(x, u)};
}

}  // namespace sightline::dds
