/// Flights against an obstacle, or other robots, that do their worst, with the barrier between each
/// robot and a command that does its worst too.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "tests/support/period.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

inline constexpr std::array<double, 4> lowest = {-1, -1, -1, -1}, highest = {1, 1, 1, 1};
using State = std::array<double, Multirotor::nx>;
using VehicleInput = std::array<double, Multirotor::nu>;

/// The filter of one multirotor.
inline Barrier barrier(const BarrierOptions& options = {}) {
  return Barrier(Multirotor{}, lowest, highest, control_period, options);
}

/// One sample of the plant; `seen` is told the position in between too.
template <class Seen>
void fly(const Multirotor& robot, State& x, const VehicleInput& u, double dt, Seen&& seen) {
  constexpr int parts = 4;
  std::array<double, RungeKuttaScratch::rows_needed * Multirotor::nx> rows;
  for (int i = 1; i <= parts; ++i) {
    rk4_step(
        [&](std::span<const double> z, std::span<double> rate) {
          State at;
          std::copy(z.begin(), z.end(), at.begin());
          const State r = robot.f(at, u);
          std::copy(r.begin(), r.end(), rate.begin());
        },
        x, dt / parts, {rows});
    seen(Vec3<double>{x[0], x[1], x[2]}, dt * i / parts);
  }
  const double length = std::hypot(x[3], x[4]);
  x[3] /= length;
  x[4] /= length;
}

/// The command that goes for a point as fast as it can.
inline VehicleInput towards(const State& x, const Vec3<double>& point) {
  const Vec3<double> r = point - Vec3<double>{x[0], x[1], x[2]};
  const double length = std::max({std::abs(r.x), std::abs(r.y), std::abs(r.z), 1e-9});
  const Vec2<double> r_V = rotate<double>({x[3], -x[4]}, {r.x / length, r.y / length});
  return {std::clamp(r_V.x, -1.0, 1.0), std::clamp(-r_V.y, -1.0, 1.0), std::clamp(r.z, -1.0, 1.0), 0.0};
}

enum class Nominal { straight_at_it, random, zero, always_down };
enum class Pursuit { turns_each_half_second, aims_ahead, turns_each_sample };

struct Duel {
  bool spatial = false;  ///< the obstacle moves in height too; else it stays at the robot's height
  bool filtered = true;
  bool moving = false;  ///< the robot starts at any velocity from which it can still flee
  Nominal nominal = Nominal::straight_at_it;
  Pursuit pursuit = Pursuit::turns_each_half_second;
  double start = 3.5, d_hard = 1.0, speed_max = 1.5, duration = 15.0, dt = 0.01;
  VehicleInput added{};  ///< what holds the robot against wind, whose limits it takes from
};

struct DuelOutcome {
  double nearest = std::numeric_limits<double>::infinity();  ///< over the flight, at any time [m]
  double lowest = std::numeric_limits<double>::infinity();   ///< least height [m]
  double largest_command = 0.0, farthest = 0.0;
  double least_reserve = std::numeric_limits<double>::infinity();
  int conflicts = 0;
  bool finite = true;
};

inline Vec3<double> any_direction(Random& random, bool spatial) {
  const double psi = uniform(random, -std::numbers::pi, std::numbers::pi);
  const double z = spatial ? uniform(random, -1, 1) : 0.0, flat = std::sqrt(1 - z * z);
  return {flat * std::cos(psi), flat * std::sin(psi), z};
}

inline DuelOutcome duel(const Barrier& barrier, const Duel& d, std::uint64_t seed) {
  const Multirotor robot;
  Random random(seed);
  const double psi = uniform(random, -std::numbers::pi, std::numbers::pi);
  State x = {0, 0, uniform(random, 0.5, 2.0), std::cos(psi), std::sin(psi), 0, 0};
  if (!d.spatial) x[2] = 1.0;
  Neighbour other{.d_hard = d.d_hard, .speed_max = d.speed_max};
  other.p = Vec3<double>{0, 0, x[2]} + d.start * any_direction(random, d.spatial);
  const State resting = x;
  for (int tries = 0; d.moving && tries < 20; ++tries) {
    x[5] = uniform(random, -2.8, 2.8);
    x[6] = uniform(random, -2.8, 2.8);
    if (barrier.reserve(x, other) >= 0) break;
    x = resting;
  }
  const double usual = random() % 2 == 0 ? d.speed_max : uniform(random, 0.0, d.speed_max);
  Vec3<double> v{};
  VehicleInput wanted{};
  DuelOutcome outcome;
  VehicleInput low = lowest, high = highest;
  for (std::size_t i = 0; i < low.size(); ++i) low[i] -= d.added[i], high[i] -= d.added[i];
  const auto periods = static_cast<int>(std::llround(d.duration / d.dt));
  for (int k = 0; k < periods; ++k) {
    const Vec3<double> p = {x[0], x[1], x[2]};
    if (k % 50 == 0 || d.pursuit == Pursuit::turns_each_sample) {
      Vec3<double> aim = p - other.p;
      if (d.pursuit == Pursuit::aims_ahead) {
        const double ahead = norm(aim) / std::max(d.speed_max, 0.1);
        const Vec2<double> v_G = rotate<double>({x[3], x[4]}, {x[5], x[6]});
        aim = aim + Vec3<double>{ahead * v_G.x, ahead * v_G.y, 0.0};
      }
      if (!d.spatial) aim.z = 0;
      const double length = std::max(norm(aim), 1e-9);
      const double stray = d.pursuit == Pursuit::turns_each_sample ? 0.0 : 0.8 * uniform(random, 0, 1);
      Vec3<double> direction = (1 / length) * aim + stray * any_direction(random, d.spatial);
      const double speed = random() % 8 == 0 ? uniform(random, 0.0, d.speed_max) : usual;
      v = (speed / std::max(norm(direction), 1e-9)) * direction;
    }
    if (d.nominal == Nominal::random && k % 50 == 0) wanted = uniform_array<4>(random, -1, 1);
    if (d.nominal == Nominal::straight_at_it) wanted = towards(x, other.p);
    if (d.nominal == Nominal::always_down) wanted = {wanted[0], wanted[1], -1.0, 1.0};

    VehicleInput u = wanted;
    if (d.filtered) {
      const BarrierResult result = barrier.filter(x, std::span(&other, 1), low, high, u);
      outcome.conflicts += result.conflict;
      outcome.least_reserve = std::min(outcome.least_reserve, result.reserve);
    }
    for (const double c : u) outcome.largest_command = std::max(outcome.largest_command, std::abs(c));
    const Vec3<double> from = other.p;
    fly(robot, x, u, d.dt, [&](const Vec3<double>& at, double t) {
      outcome.nearest = std::min(outcome.nearest, norm(at - (from + t * v)));
      outcome.lowest = std::min(outcome.lowest, at.z);
      outcome.farthest = std::max({outcome.farthest, std::abs(at.x), std::abs(at.y)});
    });
    other.p = from + d.dt * v;
    if (!d.spatial) other.p.z = x[2];
    outcome.finite = outcome.finite && all_finite(x) && all_finite(u);
  }
  return outcome;
}

/// Robots that filter all, and would rather meet.
struct Swarm {
  enum class Nominal { at_each_other, random, antipodal };

  int robots = 2;
  bool filtered = true;
  Nominal nominal = Nominal::at_each_other;
  bool head_on = false;  ///< two face each other exactly on a line
  double d_hard = 0.6, ring = 3.0, duration = 15.0, dt = 0.01;
};

struct SwarmOutcome {
  double nearest = std::numeric_limits<double>::infinity(), largest_command = 0.0;
  double least_reserve = std::numeric_limits<double>::infinity(), violation = 0.0;
  int conflicts = 0;
  double travelled = 0.0;  ///< part of the robots that came to their goals
};

inline SwarmOutcome fly_swarm(const Barrier& barrier, const Swarm& swarm, std::uint64_t seed) {
  const Multirotor robot;
  Random random(seed);
  const auto count = static_cast<std::size_t>(swarm.robots);
  std::vector<State> x(count);
  std::vector<Vec3<double>> goal(count);
  std::vector<VehicleInput> u(count), wanted(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    const double stray = swarm.head_on ? 0.0 : uniform(random, -0.1, 0.1), psi = uniform(random, -3.1, 3.1);
    const double z = swarm.head_on ? 1.5 : uniform(random, 1.0, 2.0);
    x[i] = {swarm.ring * std::cos(angle + stray),
            swarm.ring * std::sin(angle + stray),
            z,
            std::cos(psi),
            std::sin(psi),
            0,
            0};
    goal[i] = {-x[i][0], -x[i][1], z};
  }
  SwarmOutcome outcome;
  const auto periods = static_cast<int>(std::llround(swarm.duration / swarm.dt));
  std::vector<Neighbour> others;
  std::vector<std::array<Vec3<double>, 4>> path(count);
  for (int k = 0; k < periods; ++k) {
    for (std::size_t i = 0; i < count; ++i) {
      others.clear();
      std::size_t nearest = i == 0 ? 1 : 0;
      const Vec3<double> p = {x[i][0], x[i][1], x[i][2]};
      for (std::size_t j = 0; j < count; ++j) {
        if (j == i) continue;
        const Vec2<double> v = rotate<double>({x[j][3], x[j][4]}, {x[j][5], x[j][6]});
        const Vec3<double> q = {x[j][0], x[j][1], x[j][2]}, r = p - q;
        const Vec3<double> best = p - Vec3<double>{x[nearest][0], x[nearest][1], x[nearest][2]};
        if (dot(r, r) < dot(best, best)) nearest = j;
        others.push_back({.p = q,
                          .v = {v.x, v.y, 0},
                          .d_hard = swarm.d_hard,
                          .tie = i < j ? 1.0 : -1.0,
                          .behavior = Behavior::cooperative});
      }
      if (swarm.nominal == Swarm::Nominal::at_each_other)
        wanted[i] = towards(x[i], {x[nearest][0], x[nearest][1], x[nearest][2]});
      if (swarm.nominal == Swarm::Nominal::random && k % 50 == 0) wanted[i] = uniform_array<4>(random, -1, 1);
      if (swarm.nominal == Swarm::Nominal::antipodal) wanted[i] = towards(x[i], goal[i]);
      u[i] = wanted[i];
      if (!swarm.filtered) continue;
      const BarrierResult result = barrier.filter(x[i], others, lowest, highest, u[i]);
      outcome.conflicts += result.conflict;
      outcome.violation = std::max(outcome.violation, result.violation);
      outcome.least_reserve = std::min(outcome.least_reserve, result.reserve);
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (const double c : u[i]) outcome.largest_command = std::max(outcome.largest_command, std::abs(c));
      std::size_t part = 0;
      fly(robot, x[i], u[i], swarm.dt, [&](const Vec3<double>& p, double) { path[i][part++] = p; });
      for (std::size_t j = 0; j < i; ++j) {
        for (std::size_t q = 0; q < path[i].size(); ++q)
          outcome.nearest = std::min(outcome.nearest, norm(path[i][q] - path[j][q]));
      }
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    outcome.travelled += norm(Vec3<double>{x[i][0], x[i][1], x[i][2]} - goal[i]) < 1.0
                             ? 1.0 / static_cast<double>(count)
                             : 0.0;
  }
  return outcome;
}

}  // namespace sightline::test
