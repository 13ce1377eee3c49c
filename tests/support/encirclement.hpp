/// A robot among bodies that chase it: with the barrier on its command, with its command as it is,
/// and on plans without feedback.
#pragma once

#include "tests/support/adversary.hpp"

namespace sightline::test {

/// Each heads straight for the robot at its speed. One that strays turns at will each half second,
/// or aims ahead of the robot.
struct Pursuer {
  Vec3<double> p{};
  double speed = 0.5;
};

enum class Wish { stay, meet, fly_on };

struct Encirclement {
  std::vector<Pursuer> pursuers{};
  Wish wish = Wish::stay;  ///< of the robot: to stay, to meet the nearest, to fly on as at first
  double speed_max = 0.0;  ///< what the barrier is told [m/s]; 0: that of each
  double height = 1.0, heading = 0.0;
  Vec2<double> v{};    ///< at the start, of V [m/s]
  double stray = 0.0;  ///< part of the way that is any
  std::uint64_t seed = 0;
  double d_hard = 0.6, floor = 0.3, duration = 12.0, dt = 0.01;
};

/// The filter that meets them.
inline Barrier barrier_of_encirclements() { return barrier({.floor = 0.3, .ceiling = 10.0, .world = 100.0}); }

/// 2 to 6 pursuers of 0.3 to 1.5 m/s around a robot, from 0.8 to 4 m, 0.3 to 2.5 m high.
inline Encirclement any_encirclement(std::uint64_t seed) {
  Random random(seed);
  Encirclement e;
  const auto count = 2 + random() % 5;
  const double near = uniform(random, 0.8, 3.5), first = uniform(random, -3.1, 3.1);
  e.height = uniform(random, 0.5, 2.0);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = first + 2 * std::numbers::pi *
                                     (static_cast<double>(i) + uniform(random, -0.3, 0.3)) /
                                     static_cast<double>(count);
    const double far = near + uniform(random, 0.0, 0.5);
    e.pursuers.push_back({{far * std::cos(angle), far * std::sin(angle), uniform(random, 0.3, 2.5)},
                          uniform(random, 0.3, 1.5)});
  }
  e.heading = uniform(random, -3.1, 3.1);
  e.v = {uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5)};
  e.wish = static_cast<Wish>(random() % 3);
  e.speed_max = random() % 2 == 0 ? 0.0 : 1.5;
  return e;
}

/// 2 to 4 uncooperative neighbours at any place from which they may come, which turn at will.
inline Encirclement any_adversaries(std::uint64_t seed) {
  Random random(seed);
  Encirclement e{.stray = 1.0, .seed = seed, .duration = 8.0};
  e.height = uniform(random, 0.5, 2.0);
  const auto count = 2 + random() % 3;
  const double speed = uniform(random, 0.2, 1.5);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3<double> away = any_direction(random, true);
    e.pursuers.push_back(
        {Vec3<double>{0, 0, e.height} + uniform(random, 1.0 + speed, 2.0 + 3 * speed) * away, speed});
  }
  e.heading = uniform(random, -3.1, 3.1);
  e.wish = static_cast<Wish>(random() % 3);
  return e;
}

struct Fate {
  double nearest = std::numeric_limits<double>::infinity(), lowest = nearest;
  double reported = std::numeric_limits<double>::infinity();  ///< time of the first conflict [s]
  double broken = std::numeric_limits<double>::infinity();    ///< when the hard distance was [s]
  double largest_command = 0.0;
};

/// @param command  u of (x, pursuers, velocities, t), before each period
template <class CommandOf>
Fate fly_among(const Encirclement& e, CommandOf&& command) {
  const Multirotor robot;
  State x = {0, 0, e.height, std::cos(e.heading), std::sin(e.heading), e.v.x, e.v.y};
  std::vector<Pursuer> pursuers = e.pursuers;
  std::vector<Vec3<double>> v(pursuers.size());
  Random random(e.seed);
  Fate fate;
  const auto periods = static_cast<int>(std::llround(e.duration / e.dt));
  for (int k = 0; k < periods; ++k) {
    const double t = e.dt * k;
    const VehicleInput u = command(x, pursuers, v, t);
    for (const double c : u) fate.largest_command = std::max(fate.largest_command, std::abs(c));
    const Vec3<double> p = {x[0], x[1], x[2]};
    for (std::size_t i = 0; i < pursuers.size(); ++i) {
      const Vec3<double> r = p - pursuers[i].p;
      const double gap = norm(r);
      if (e.stray == 0) {
        v[i] = gap > 0 ? (std::min(pursuers[i].speed, gap / e.dt) / gap) * r : Vec3<double>{};
        continue;
      }
      if (k % 50 != 0) continue;
      const Vec3<double> way =
          (1 / std::max(gap, 1e-9)) * r + e.stray * uniform(random, 0, 1) * any_direction(random, true);
      v[i] = (pursuers[i].speed / std::max(norm(way), 1e-9)) * way;
    }
    fly(robot, x, u, e.dt, [&](const Vec3<double>& at, double after) {
      fate.lowest = std::min(fate.lowest, at.z);
      for (std::size_t i = 0; i < pursuers.size(); ++i) {
        const double distance = norm(at - (pursuers[i].p + after * v[i]));
        fate.nearest = std::min(fate.nearest, distance);
        if (distance < e.d_hard) fate.broken = std::min(fate.broken, t + after);
      }
    });
    for (std::size_t i = 0; i < pursuers.size(); ++i) pursuers[i].p = pursuers[i].p + e.dt * v[i];
  }
  return fate;
}

inline VehicleInput wish(const Encirclement& e, const State& x, std::span<const Pursuer> pursuers) {
  if (e.wish == Wish::fly_on) return {e.v.x, e.v.y, 0.0, 0.2};
  Vec3<double> goal = {0, 0, e.height};
  const Vec3<double> p = {x[0], x[1], x[2]};
  if (e.wish == Wish::meet) {
    goal = std::min_element(pursuers.begin(), pursuers.end(), [&](const Pursuer& a, const Pursuer& b) {
             return norm(a.p - p) < norm(b.p - p);
           })->p;
    return towards(x, goal);
  }
  const Vec2<double> r = rotate<double>({x[3], -x[4]}, {goal.x - x[0], goal.y - x[1]});
  return {std::clamp(r.x - x[5], -1.0, 1.0), std::clamp(-(r.y - x[6]), -1.0, 1.0),
          std::clamp(2 * (goal.z - x[2]), -1.0, 1.0), 0.0};
}

inline Fate fly_wish(const Encirclement& e) {
  return fly_among(
      e, [&](const State& x, const auto& pursuers, const auto&, double) { return wish(e, x, pursuers); });
}

inline Fate fly_filtered(const Barrier& barrier, const Encirclement& e) {
  EvasiveManeuver maneuver;
  std::vector<Neighbour> others;
  double reported = std::numeric_limits<double>::infinity();
  Fate fate = fly_among(e, [&](const State& x, const auto& pursuers, const auto& v, double t) {
    others.clear();
    for (std::size_t i = 0; i < pursuers.size(); ++i) {
      others.push_back({.p = pursuers[i].p,
                        .v = v[i],
                        .d_hard = e.d_hard,
                        .speed_max = e.speed_max > 0 ? e.speed_max : pursuers[i].speed});
    }
    VehicleInput u = wish(e, x, pursuers);
    if (barrier.filter(x, others, lowest, highest, u, maneuver).conflict) reported = std::min(reported, t);
    return u;
  });
  fate.reported = reported;
  return fate;
}

/// Whether one plan is safe at the start, whatever they do, and the filter reckons with them
/// together.
inline bool is_safe_from_all(const Barrier& barrier, const Encirclement& e) {
  const State x = {0, 0, e.height, std::cos(e.heading), std::sin(e.heading), e.v.x, e.v.y};
  std::vector<Neighbour> others;
  for (const Pursuer& pursuer : e.pursuers)
    others.push_back({.p = pursuer.p, .d_hard = e.d_hard, .speed_max = pursuer.speed});
  VehicleInput u{};
  const BarrierResult result = barrier.filter(x, others, lowest, highest, u);
  return !result.surrounded && result.reserve >= 0;
}

/// One of 500: 20 directions, 5 vertical speeds, 5 times of beginning; zero commands before.
inline Fate fly_plan(const Encirclement& e, int index) {
  const double angle = 2 * std::numbers::pi * (index % 20) / 20, climb = -1.0 + 0.5 * (index / 20 % 5);
  const double begin = std::array{0.0, 0.4, 0.8, 1.5, 2.5}[static_cast<std::size_t>(index / 100)];
  const double size = std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
  return fly_among(e, [&](const State& x, const auto&, const auto&, double t) -> VehicleInput {
    if (t < begin - 1e-9) return {};
    // Not below the floor: it levels out there.
    const double rise = x[2] + e.dt * climb < e.floor ? std::max(climb, (e.floor - x[2]) / e.dt) : climb;
    return {std::cos(angle) / size, -std::sin(angle) / size, rise, 0.0};
  });
}

/// Whether one of the plans keeps the distance and the floor.
inline bool has_maneuver(const Encirclement& e) {
  for (int i = 0; i < 500; ++i) {
    const Fate fate = fly_plan(e, i);
    if (fate.nearest >= e.d_hard && fate.lowest >= e.floor - 1e-9) return true;
  }
  return false;
}

}  // namespace sightline::test
