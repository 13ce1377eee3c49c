/// A certified view checked by code of its own: reserves by simulated braking, states of the set
/// and its boundary, moves of a target.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/safety/view_certificate.hpp"
#include "sightline/safety/view_filter.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

/// Limits of the paper's view: a sensor and 1 to 2 m from centre to centre.
inline std::vector<Potential> view_limits(const Potential& sensor, double d_min = 1.0, double d_max = 2.0) {
  return {sensor, KeepOut{.d_min = d_min}, Cohesion{.d_max = d_max}};
}
inline std::vector<Potential> cone_limits(double alpha = 0.5, MountFrame frame = MountFrame::level) {
  return view_limits(SensorCone{.alpha = alpha, .mount = {.frame = frame}});
}
/// A cone of a camera beside the nose that looks a little to the left, rolled.
inline std::vector<Potential> askew_limits(MountFrame frame) {
  return view_limits(SensorCone{
      .alpha = 0.5,
      .mount = {.pitch = 0.5, .offset = {0.1, -0.08, 0.05}, .frame = frame, .yaw = 0.12, .roll = 1.2}});
}
/// The paper's cone, of a sensor that looks aside and sits there.
inline std::vector<Potential> aside_limits(double yaw, MountFrame frame = MountFrame::level) {
  return view_limits(SensorCone{
      .alpha = 0.5,
      .mount = {.offset = {0.12 * std::cos(yaw), 0.12 * std::sin(yaw), 0.04}, .frame = frame, .yaw = yaw}});
}
/// A picture of 69 by 42 degrees, as text.
inline std::vector<Potential> pyramid_limits() {
  return view_limits(Region(all_of({"x > 0 m", "abs(y) < x * tan(34.5 deg)", "abs(z) < x * tan(21 deg)"}))
                         .seen_from(SensorMount{}));
}

template <RobotModel M>
ViewTask view_task(const M& robot, const ViewBounds& bounds = {}, const std::vector<Potential>& limits = {}) {
  const Model model(robot);
  return {.motion = view_motion(model, model.u_min(), model.u_max(), view_direction(limits)),
          .bounds = bounds,
          .dt = 0.01};
}

/// A robot's state in the plane of the theorem, and the target's. The robot is at the origin of G.
struct ViewState {
  double psi = 0, z = 0;  // heading [rad], height [m]
  Vec2<double> v{};       // velocity in V [m/s]
  Vec3<double> target{};  // in G [m]
  Vec2<double> w{};       // velocity of the target in G [m/s]
  double climb = 0;       // vertical speed [m/s], where it is a state
  double turn = 0;        // yaw rate [rad/s], where it is a state
};

/// Yaw of the frame of a set from the heading [rad].
inline double yaw_of(const ViewCertificate& z) {
  return std::atan2(z.task.motion.ahead.y, z.task.motion.ahead.x);
}

/// Index of a state by its name, or -1.
inline int state_named(const Model& model, std::string_view name) {
  const auto found = std::find(model.states().begin(), model.states().end(), name);
  return found == model.states().end() ? -1 : static_cast<int>(found - model.states().begin());
}

/// The model's state with this pose and motion, by the names of its states.
inline std::vector<double> state_of(const Model& model, const ViewState& s) {
  std::vector<double> x(static_cast<std::size_t>(model.nx()));
  model.at_rest({{0, 0, s.z}, {std::cos(s.psi), std::sin(s.psi)}}, x.data());
  for (const auto& [name, value] : {std::pair{"v_f", s.v.x}, {"v_s", s.v.y}, {"v_z", s.climb}, {"r", s.turn}})
    if (const int k = state_named(model, name); k >= 0) x[static_cast<std::size_t>(k)] = value;
  return x;
}

/// Reserves of a set by formulas of their own: the braking distance by small steps in time.
class ViewChecker {
 public:
  explicit ViewChecker(const ViewCertificate& z) : z_(z) {
    // A flight from a high speed to -W_e at full thrust, backwards in time: speed and distance.
    constexpr double step = 1e-4;
    const double c = z.brake.drag, b = z.brake.thrust + c * z.brake.speed;
    double v = -z.brake.speed, d = 0.0;
    for (int k = 0; v < 12.0 && k < 400000; ++k) {
      speeds_.push_back(v), distances_.push_back(d);
      const double middle = v + 0.5 * step * (b + c * v), next = v + step * (b + c * middle);
      d += step * (0.5 * (v + next) + z.brake.speed), v = next;
    }
  }
  double braking(double v) const {
    if (v <= speeds_.front()) return 0.0;
    const auto after = std::upper_bound(speeds_.begin(), speeds_.end(), v);
    if (after == speeds_.end()) return infinity;
    const auto k = static_cast<std::size_t>(after - speeds_.begin());
    const double part = (v - speeds_[k - 1]) / (speeds_[k] - speeds_[k - 1]);
    return distances_[k - 1] + part * (distances_[k] - distances_[k - 1]);
  }
  /// The least of the reserves of S; velocities count in m.
  /// @param turn  yaw rate of the robot, if it lags [rad/s]
  double least(const Sight<double>& robot, const Vec3<double>& target, const Vec2<double>& w,
               double turn = 0.0) const {
    const double ahead = std::atan2(robot.d.y, robot.d.x) + yaw_of(z_);
    const double climb_lag = z_.task.motion.climb.lag, turn_lag = z_.task.motion.turn.lag;
    const double x = target.x - robot.p.x, y = target.y - robot.p.y, r = std::hypot(x, y),
                 h = robot.p.z + climb_lag * robot.v.z - target.z;
    const double theta = std::remainder(std::atan2(y, x) - ahead - turn_lag * turn, 2 * std::numbers::pi);
    const bool measured = std::isfinite(z_.task.bounds.acceleration);
    const double v_x = robot.v.x - (measured ? w.x : 0), v_y = robot.v.y - (measured ? w.y : 0);
    const double v_f = v_x * std::cos(ahead) + v_y * std::sin(ahead),
                 v_s = v_y * std::cos(ahead) - v_x * std::sin(ahead);
    double s = (r - z_.near) / (z_.far - z_.near) * static_cast<double>(z_.low.size() - 1);
    s = std::min(std::max(s, 0.0), static_cast<double>(z_.low.size() - 1));
    const auto k = std::min(static_cast<std::size_t>(s), z_.low.size() - 2);
    const double part = s - static_cast<double>(k);
    const double low = (1 - part) * z_.low[k] + part * z_.low[k + 1],
                 high = (1 - part) * z_.high[k] + part * z_.high[k + 1];
    return std::min({r - z_.near - braking(v_f), z_.far - r - braking(-v_f), (z_.theta - std::abs(theta)) * r,
                     h - low, high - h, z_.task.motion.across.input < 0 ? 1.0 : z_.sideward - std::abs(v_s),
                     climb_lag > 0 ? z_.climb - std::abs(robot.v.z) : 1.0,
                     turn_lag > 0 ? z_.turn - std::abs(turn) : 1.0});
  }

 private:
  ViewCertificate z_;
  std::vector<double> speeds_, distances_;
};

/// A number from a to b; near an end in two of three cases, down to 1e-6 of the width.
inline double edgy(Random& random, bool edge, double a, double b) {
  const double q = uniform(random, 0, 1), near = std::pow(10.0, uniform(random, -6, -1));
  if (!edge || q > 0.7) return uniform(random, a, b);
  return q < 0.35 ? a + (b - a) * near : b - (b - a) * near;
}

/// A state of the set; `edge`: at its boundary, in its corners too.
inline ViewState state_in(const ViewCertificate& z, Random& random, bool edge) {
  ViewState s;
  s.psi = uniform(random, -3, 3), s.z = uniform(random, 3, 5);
  const double speed = edgy(random, edge, 0, z.task.bounds.speed), along = uniform(random, -3.2, 3.2);
  s.w = {speed * std::cos(along), speed * std::sin(along)};
  const bool measured = z.task.bounds.is_velocity_measured();
  const double yaw = yaw_of(z), towards = s.psi + yaw;
  const Vec2<double> w_V =
      measured ? rotate<double>({std::cos(towards), -std::sin(towards)}, s.w) : Vec2<double>{};
  double r, slow, fast;
  do {
    r = edgy(random, edge, z.near, z.far);
    slow = -z.brake.fastest(z.far - r), fast = z.brake.fastest(r - z.near);
  } while (fast < slow);
  const bool across = z.task.motion.across.input >= 0;
  s.v = {w_V.x + edgy(random, edge, slow, fast),
         w_V.y + (across ? edgy(random, edge, -z.sideward, z.sideward) : 0.0)};
  s.v = rotate<double>({std::cos(yaw), std::sin(yaw)}, s.v);
  const ViewMotion& motion = z.task.motion;
  if (motion.climb.lag > 0) s.climb = edgy(random, edge, -z.climb, z.climb);
  if (motion.turn.lag > 0) s.turn = edgy(random, edge, -z.turn, z.turn);
  const double theta = edgy(random, edge, -z.theta, z.theta) + motion.turn.lag * s.turn,
               h = edgy(random, edge, z.at(z.low, r), z.at(z.high, r)) - motion.climb.lag * s.climb;
  s.target = {r * std::cos(towards + theta), r * std::sin(towards + theta), s.z - h};
  return s;
}

/// Moves a target for a period: at full speed along a direction of G, or with full acceleration.
inline void move(ViewState& s, const ViewBounds& bounds, const Vec2<double>& direction, double climb,
                 double dt) {
  if (bounds.is_velocity_measured()) {
    Vec2<double> next = {s.w.x + dt * bounds.acceleration * direction.x,
                         s.w.y + dt * bounds.acceleration * direction.y};
    const double speed = std::hypot(next.x, next.y);
    if (speed > bounds.speed) next = {next.x * bounds.speed / speed, next.y * bounds.speed / speed};
    s.target.x += 0.5 * dt * (s.w.x + next.x), s.target.y += 0.5 * dt * (s.w.y + next.y), s.w = next;
  } else {
    s.w = {bounds.speed * direction.x, bounds.speed * direction.y};
    s.target.x += dt * s.w.x, s.target.y += dt * s.w.y;
  }
  s.target.z += dt * bounds.climb * climb;
}

/// The k-th of 48 moves: 16 directions at three climbs.
inline constexpr int moves = 48;
inline void move(ViewState& s, const ViewBounds& bounds, int k, double dt) {
  const double a = k % 16 * std::numbers::pi / 8;
  const int climb = k / 16 - 1;
  move(s, bounds, {std::cos(a), std::sin(a)}, climb, dt);
}

/// What one period did to many states of a set.
struct ViewStep {
  int states = 0, uncertified = 0, outside = 0;
  double least = infinity;  // [m]
};

/// Filters a command at states of the set, and moves the target in 48 ways; and the robot by the
/// greatest errors of its odometry.
template <RobotModel M>
ViewStep one_step(const M& robot, const ViewCertificate& z, int states, std::uint64_t seed) {
  const Model model(robot);
  const ViewFilter filter(model, z);
  const ViewChecker checker(z);
  const int rate_state = state_named(model, "r");
  Random random(seed);
  ViewStep all;
  std::vector<double> u(static_cast<std::size_t>(model.nu()));
  for (; all.states < states; ++all.states) {
    const ViewState s = state_in(z, random, all.states % 8 != 0);
    std::vector<double> x = state_of(model, s);
    for (std::size_t k = 0; k < u.size(); ++k)
      u[k] = random() & 1 ? uniform(random, -1.2, 1.2) * model.u_max()[k]
                          : (random() & 1 ? 1 : -1) * model.u_max()[k];
    all.uncertified += !filter.filter(x, {s.target, s.w}, model.u_min(), model.u_max(), u).certified;
    model.step(x.data(), u.data(), z.task.dt);
    const Sight<double> then = model.sight(x.data(), u.data());
    const double turned = z.task.dt * z.task.odometry.turn, climbed = z.task.dt * z.task.odometry.velocity;
    const double turn = rate_state < 0 ? 0.0 : x[static_cast<std::size_t>(rate_state)];
    double least = infinity;
    for (int k = 0; k < moves; ++k) {
      ViewState moved = s;
      move(moved, z.task.bounds, k, z.task.dt);
      Sight<double> off = then;
      const double sign = k % 2 == 0 ? 1.0 : -1.0;
      const Vec2<double> by = {std::cos(turned), sign * std::sin(turned)},
                         v = rotate<double>(by, {then.v.x, then.v.y});
      off.d = rotate(by, then.d), off.v.x = v.x, off.v.y = v.y;
      off.p.z += k / 16 == 0 ? climbed : -climbed;
      least = std::min(least, checker.least(off, moved.target, moved.w, turn));
    }
    all.least = std::min(all.least, least);
    all.outside += least < -2e-6;
  }
  return all;
}

}  // namespace sightline::test
