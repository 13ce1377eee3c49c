/// Unicycles that drive among rocks, other robots and pursuers, each behind its barrier. The motion
/// is integrated in closed form along v and psi, and by Simpson's rule along p.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/base.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

inline constexpr std::array<double, 2> drive_low = {-1, -1}, drive_high = {1, 1};
using Rover = std::array<double, sightline::Unicycle::nx>;
using DriveInput = std::array<double, sightline::Unicycle::nu>;

inline Rover rover(const Vec2<double>& p, double psi, double speed) {
  return {p.x, p.y, 0.2, std::cos(psi), std::sin(psi), speed};
}
inline Vec3<double> at(const Rover& x) { return {x[0], x[1], x[2]}; }
inline Vec3<double> velocity(const Rover& x) { return {x[5] * x[3], x[5] * x[4], 0}; }

inline Barrier drive_barrier(const sightline::Unicycle& model, double dt, BarrierOptions options = {}) {
  options.rate = std::min(options.rate, 1 / dt);
  return Barrier(model, drive_low, drive_high, dt, options);
}

/// Advances a rover by dt; `seen` is told the position at least each 5 ms.
template <class Seen>
void drive(const sightline::Unicycle& model, Rover& x, const DriveInput& u, double dt, Seen&& seen) {
  const int parts = std::max(2, static_cast<int>(std::ceil(dt / 0.005)));
  const double h = dt / parts, c = -model.a_f, a = model.b_f * u[0], turn = model.b_psi * u[1];
  for (int k = 0; k < parts; ++k) {
    const double psi = std::atan2(x[4], x[3]), v = x[5];
    const auto speed = [&](double t) {
      return c > 0 ? v * std::exp(-c * t) + a / c * (1 - std::exp(-c * t)) : v + a * t;
    };
    constexpr std::array weights = {1.0, 4.0, 2.0, 4.0, 1.0};
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double t = h * static_cast<double>(i) / 4;
      x[0] += h / 12 * weights[i] * speed(t) * std::cos(psi + turn * t);
      x[1] += h / 12 * weights[i] * speed(t) * std::sin(psi + turn * t);
    }
    x[3] = std::cos(psi + turn * h), x[4] = std::sin(psi + turn * h), x[5] = speed(h);
    seen(at(x));
  }
}

/// Braking by 0.9 of the greatest command; where that would reverse within a period, by what stops
/// the robot at its end.
struct Brake {
  std::vector<Vec3<double>> path;
  double time = 0.0;  // [s]
};
inline Brake simulated_brake(const sightline::Unicycle& model, Rover x, double dt) {
  Brake brake{.path = {at(x)}};
  while (std::abs(x[5]) > 1e-6) {
    double less = 0.0, more = 0.9;
    for (int k = 0; k < 60; ++k) {  // bisects the braking command of this period
      const double middle = 0.5 * (less + more);
      Rover next = x;
      drive(model, next, {x[5] > 0 ? -middle : middle, 0}, dt, [](const Vec3<double>&) {});
      (next[5] * x[5] > 0 ? less : more) = middle;
    }
    drive(model, x, {x[5] > 0 ? -more : more, 0}, dt,
          [&](const Vec3<double>& p) { brake.path.push_back(p); });
    brake.time += dt;
  }
  return brake;
}
inline double braking_distance(const sightline::Unicycle& model, double speed, double dt) {
  return norm(simulated_brake(model, rover({0, 0}, 0, speed), dt).path.back() - Vec3<double>{0, 0, 0.2});
}

/// A rover as another knows it.
inline Neighbour member(const Rover& x, double d_hard, double tie) {
  return {.p = at(x), .v = velocity(x), .d_hard = d_hard, .tie = tie, .behavior = Behavior::cooperative};
}

struct OneStep {
  double least_reserve =
      std::numeric_limits<double>::infinity();  ///< after the step, less what was required [m]
  double least_distance = std::numeric_limits<double>::infinity();  ///< in between, less d_hard [m]
  int conflicts = 0, changed = 0;
};

/// One period from states at the boundary of the set of two cooperative rovers, with hostile
/// commands and bodies.
inline OneStep one_steps(int count, std::uint64_t seed) {
  Random random(seed);
  OneStep found;
  for (int i = 0; i < count; ++i) {
    const double dt = std::array{0.01, 0.05, 0.2, 0.5}[static_cast<std::size_t>(i % 4)];
    const sightline::Unicycle model{
        .b_psi = uniform(random, 0.5, 9), .a_f = -uniform(random, 0.2, 4), .b_f = uniform(random, 1, 4)};
    const Barrier filter = drive_barrier(model, dt);
    const auto any_rover = [&] {
      return rover({0, 0}, uniform(random, -3.2, 3.2), uniform(random, -1.5, 1.5));
    };
    std::array<Rover, 2> x = {any_rover(), any_rover()};
    // Bodies whose reserve is about zero: against the first rover, in any direction.
    const auto place = [&](const auto& put) {
      const double psi = uniform(random, -3.2, 3.2), wanted = i % 2 == 0 ? 0.0 : uniform(random, 0, 0.05);
      double near = 0.0, far = 40.0;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (near + far);
        (filter.reserve(x[0], put({middle * std::cos(psi), middle * std::sin(psi)})) < wanted ? near : far) =
            middle;
      }
      (void)put({far * std::cos(psi), far * std::sin(psi)});
    };
    std::vector<Neighbour> bodies(2 + random() % 3);
    place([&](const Vec2<double>& p) {
      x[1][0] = p.x, x[1][1] = p.y;
      return member(x[1], 0.5, -1);
    });
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      bodies[k] = {.d_hard = uniform(random, 0.3, 1),
                   .speed_max = k % 2 == 0 ? 0.0 : uniform(random, 0.1, 3)};
      place([&](const Vec2<double>& p) {
        bodies[k].p = {p.x, p.y, 0.2};
        return bodies[k];
      });
    }
    std::array<DriveInput, 2> u;
    std::array<std::vector<double>, 2> before;
    for (std::size_t r = 0; r < 2; ++r) {
      std::vector<Neighbour> all = {member(x[1 - r], 0.5, r == 0 ? 1 : -1)};
      if (r == 0) all.insert(all.end(), bodies.begin(), bodies.end());
      for (const Neighbour& n : all) before[r].push_back(filter.reserve(x[r], n));
      u[r] = i % 3 == 0 ? DriveInput{x[r][5] > 0 ? 1.0 : -1.0, uniform(random, -1, 1)}
                        : uniform_array<2>(random, -1, 1);
      const BarrierResult result = filter.filter(x[r], all, drive_low, drive_high, u[r]);
      found.conflicts += result.conflict;
      found.changed += result.active;
    }
    std::array<std::vector<Vec3<double>>, 2> path;
    for (std::size_t r = 0; r < 2; ++r)
      drive(model, x[r], u[r], dt, [&](const Vec3<double>& p) { path[r].push_back(p); });
    for (std::size_t k = 0; k < path[0].size(); ++k)
      found.least_distance = std::min(found.least_distance, norm(path[0][k] - path[1][k]) - 0.5);
    const double kept = 1 - filter.options().rate * dt;
    found.least_reserve =
        std::min(found.least_reserve, filter.reserve(x[0], member(x[1], 0.5, 1)) - kept * before[0][0]);
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const Vec3<double> r = at(x[0]) - bodies[k].p;
      for (std::size_t j = 0; j < path[0].size(); ++j) {
        const double t = dt * static_cast<double>(j + 1) / static_cast<double>(path[0].size());
        if (std::abs(x[0][5]) > 1e-6)
          found.least_distance =
              std::min(found.least_distance,
                       norm(path[0][j] - bodies[k].p) - bodies[k].d_hard - bodies[k].speed_max * t);
      }
      bodies[k].p = bodies[k].p + (dt * bodies[k].speed_max / norm(r)) * r;
      if (bodies[k].speed_max > 0 && std::abs(x[0][5]) <= 1e-6) continue;  // it stands
      const double required = bodies[k].speed_max > 0 ? 0.0 : kept * before[0][1 + k];
      found.least_reserve = std::min(found.least_reserve, filter.reserve(x[0], bodies[k]) - required);
    }
  }
  return found;
}

struct Drive {
  int rovers = 6, pursuers = 0, rocks = 4;
  double duration = 10.0, dt = 0.01, d_hard = 0.5, ring = 2.5;
  bool filtered = true;
};

struct DriveOutcome {
  double nearest = std::numeric_limits<double>::infinity();  ///< of rovers, to each other and rocks [m]
  double fastest_when_near = 0.0;  ///< speed of a rover while a pursuer is nearer than d_hard [m/s]
  double largest_command = 0.0, travelled = 0.0;  ///< distance of the average rover [m]
  double d_hard = 0.0;
  int conflicts = 0;
};

/// Rovers that would rather meet, drive into rocks, or go anywhere, hunted by pursuers that aim at
/// the nearest one.
inline DriveOutcome drive_among(const Drive& d, std::uint64_t seed) {
  Random random(seed);
  const sightline::Unicycle model;
  const Barrier filter = drive_barrier(model, d.dt);
  DriveOutcome outcome{.d_hard = d.d_hard};
  std::vector<Rover> x;
  std::vector<Neighbour> rocks, pursuers;
  const auto clear = [&](const Vec2<double>& p) {
    const Vec3<double> q = {p.x, p.y, 0.2};
    const auto far = [&](const Vec3<double>& other) { return norm(q - other) > d.d_hard + 0.05; };
    return std::all_of(x.begin(), x.end(), [&](const Rover& one) { return far(at(one)); }) &&
           std::all_of(rocks.begin(), rocks.end(), [&](const Neighbour& one) { return far(one.p); });
  };
  const auto any_place = [&] {
    for (;;) {
      const Vec2<double> p = {uniform(random, -d.ring, d.ring), uniform(random, -d.ring, d.ring)};
      if (clear(p)) return p;
    }
  };
  for (int i = 0; i < d.rovers; ++i) x.push_back(rover(any_place(), uniform(random, -3.2, 3.2), 0.0));
  for (int i = 0; i < d.rocks; ++i) {
    const Vec2<double> p = any_place();
    rocks.push_back({.p = {p.x, p.y, 0.2}, .d_hard = d.d_hard, .speed_max = 0.0});
  }
  for (int i = 0; i < d.pursuers; ++i)
    pursuers.push_back({.p = {uniform(random, -1, 1) * 2 * d.ring, 2 * d.ring, uniform(random, 0, 2)},
                        .d_hard = d.d_hard,
                        .speed_max = uniform(random, 0.3, 2.5)});
  std::vector<DriveInput> wanted(x.size()), u(x.size());
  const auto periods = static_cast<int>(std::llround(d.duration / d.dt));
  for (int k = 0; k < periods; ++k) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      std::vector<Neighbour> all = rocks;
      all.insert(all.end(), pursuers.begin(), pursuers.end());
      Vec3<double> aim{};
      double near = 1e9;
      for (std::size_t j = 0; j < x.size(); ++j) {
        if (j == i) continue;
        all.push_back(member(x[j], d.d_hard, i < j ? 1 : -1));
        if (norm(at(x[j]) - at(x[i])) < near) near = norm(at(x[j]) - at(x[i])), aim = at(x[j]);
      }
      if (k % 40 == 0) wanted[i] = uniform_array<2>(random, -1, 1);
      if ((i + seed) % 3 == 0) {  // at the next one
        const Vec3<double> r = aim - at(x[i]);
        wanted[i] = {r.x * x[i][3] + r.y * x[i][4] > 0 ? 1.0 : -1.0,
                     std::clamp(3 * (x[i][3] * r.y - x[i][4] * r.x), -1.0, 1.0)};
      }
      u[i] = wanted[i];
      if (d.filtered) outcome.conflicts += filter.filter(x[i], all, drive_low, drive_high, u[i]).conflict;
    }
    std::vector<std::vector<Vec3<double>>> path(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (const double c : u[i]) outcome.largest_command = std::max(outcome.largest_command, std::abs(c));
      drive(model, x[i], u[i], d.dt, [&](const Vec3<double>& p) { path[i].push_back(p); });
      outcome.travelled += d.dt * std::abs(x[i][5]) / static_cast<double>(x.size());
      for (std::size_t s = 0; s < path[i].size(); ++s) {
        for (std::size_t j = 0; j < i; ++j)
          outcome.nearest = std::min(outcome.nearest, norm(path[i][s] - path[j][s]));
        for (const Neighbour& rock : rocks)
          outcome.nearest = std::min(outcome.nearest, norm(path[i][s] - rock.p));
      }
    }
    for (Neighbour& one : pursuers) {
      Vec3<double> aim = at(x.front());
      for (const Rover& other : x)
        if (norm(at(other) - one.p) < norm(aim - one.p)) aim = at(other);
      const Vec3<double> r = aim - one.p;
      one.v = (one.speed_max / std::max(norm(r), 1e-6)) * r;
      if (k % 300 > 200) one.v = -1.0 * one.v;  // retreats at times
      one.p = one.p + d.dt * one.v;
      for (const Rover& other : x) {
        if (norm(at(other) - one.p) < d.d_hard)
          outcome.fastest_when_near = std::max(outcome.fastest_when_near, std::abs(other[5]));
      }
    }
  }
  return outcome;
}

}  // namespace sightline::test
