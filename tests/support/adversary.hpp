/// Flights of one robot against an obstacle that does its worst, with the barrier between the robot and a command
/// that does its worst too.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "sightline/math/integrate.hpp"
#include "sightline/model/robots.hpp"
#include "sightline/safety/barrier.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

inline constexpr std::array<double, 4> lowest = {-1, -1, -1, -1}, highest = {1, 1, 1, 1};
using State = std::array<double, Multirotor::nx>;
using Command = std::array<double, Multirotor::nu>;

/// One sample of the plant; `seen` is told the position in between too.
template <class Seen>
void fly(const Multirotor& robot, State& x, const Command& u, double dt, Seen&& seen) {
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
inline Command towards(const State& x, const Vec3<double>& point) {
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
};

struct DuelOutcome {
  double nearest = std::numeric_limits<double>::infinity();  ///< over the flight, samples and between [m]
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
  Command wanted{};
  DuelOutcome outcome;
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

    Command u = wanted;
    if (d.filtered) {
      const BarrierResult result = barrier.filter(x, std::span(&other, 1), lowest, highest, u);
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

}  // namespace sightline::test
