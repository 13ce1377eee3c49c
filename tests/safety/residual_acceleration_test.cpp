// Robots that are pushed by more than their models know, and whose commands act late.
#include <gtest/gtest.h>

#include <deque>
#include <string>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/robots.hpp"
#include "tests/support/adversary.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::control_period;
using test::highest;
using test::lowest;
using test::State;
using test::VehicleInput;

/// One period of (24) with a further acceleration w of G, by small explicit steps of its own.
template <class Seen>
void fly_pushed(State& x, const VehicleInput& u, const Vec2<double>& w, Seen&& seen) {
  constexpr int steps = 20;
  constexpr double h = control_period / steps;
  const Multirotor m;
  for (int k = 0; k < steps; ++k) {
    const double turn = h * m.b_psi * u[3], c = std::cos(turn), s = std::sin(turn);
    const Vec2<double> d = {x[3], x[4]}, v = rotate(d, Vec2<double>{x[5], x[6]});
    const Vec2<double> w_V = rotate<double>({d.x, -d.y}, w);
    const double f = m.a_f * x[5] + m.b_f * u[0] + w_V.x, l = m.a_s * x[6] - m.b_s * u[1] + w_V.y;
    const Vec2<double> a = rotate(d, Vec2<double>{f, l});
    x[0] += h * v.x + 0.5 * h * h * a.x, x[1] += h * v.y + 0.5 * h * h * a.y, x[2] += h * m.b_z * u[2];
    x[5] += h * f, x[6] += h * l;
    x[3] = d.x * c - d.y * s, x[4] = d.x * s + d.y * c;
    seen(Vec3<double>{x[0], x[1], x[2]});
  }
}

/// A robot whose commands take effect `late` periods after the measurement they follow from.
struct LateRobot {
  LateRobot(const State& start, int late) : x(start), on_the_way(static_cast<std::size_t>(late)) {}

  /// The state in which the next command takes effect, by the model alone.
  State predicted() const {
    State then = x;
    for (const VehicleInput& u : on_the_way)
      test::fly(Multirotor{}, then, u, control_period, [](const Vec3<double>&, double) {});
    return then;
  }
  template <class Seen>
  void fly(const VehicleInput& u, const Vec2<double>& w, Seen&& seen) {
    on_the_way.push_back(u);
    fly_pushed(x, on_the_way.front(), w, seen);
    on_the_way.pop_front();
  }
  Vec3<double> p() const { return {x[0], x[1], x[2]}; }

  State x;
  std::deque<VehicleInput> on_the_way;
};

Barrier counting(double w, int late, BarrierOptions options = {}) {
  options.residual_acceleration = w;
  options.command_delay = late * control_period;
  options.authority = 1.0;
  return test::barrier(options);
}

State any_state(Random& random, double speed) {
  const double psi = uniform(random, -3.2, 3.2);
  return {
      0, 0, 1, std::cos(psi), std::sin(psi), uniform(random, -speed, speed), uniform(random, -speed, speed)};
}

Vec2<double> level(const Vec3<double>& r, double size) {
  const double length = std::max(norm(r.x, r.y), 1e-9);
  return {size / length * r.x, size / length * r.y};
}

TEST(ResidualAcceleration, TakesFromEachPlanWhatTheWorstPushDoesSinceTheMeasurement) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const double w = uniform(random, 0, 0.5);
    const int late = static_cast<int>(random() % 20);
    const State x = any_state(random, 2.0);
    Neighbour n{.d_hard = 0.6, .speed_max = uniform(random, 0, 1)};
    n.p = Vec3<double>{0, 0, 1} + uniform(random, 1, 5) * test::any_direction(random, true);
    double best = -infinity;
    for (const double u_f : {-1.0, 1.0}) {
      for (const double u_s : {-1.0, 1.0}) {
        // The deviation grows from the measurement on, by the drag of (24) alone.
        double deviation = 0, rate = 0, least = infinity;
        const auto push_on = [&] {
          for (int k = 0; k < 10; ++k) {
            constexpr double h = control_period / 10;
            deviation += h * rate + 0.5 * h * h * w;
            rate += h * (w + Multirotor{}.a_f * rate);
          }
        };
        for (int k = 0; k < late; ++k) push_on();
        State then = x;
        for (int k = 0; k <= 800; ++k) {
          least = std::min(least, norm(Vec3<double>{then[0], then[1], then[2]} - n.p) - n.d_hard - 0.002 -
                                      n.speed_max * control_period * k - deviation);
          test::fly(Multirotor{}, then, {u_f, u_s, 0, 0}, control_period, [](const Vec3<double>&, double) {});
          push_on();
        }
        best = std::max(best, least);
      }
    }
    EXPECT_NEAR(counting(w, late).reserve(x, n), best, 5e-3) << i;
  }
}

struct Pushed {
  double nearest = infinity, reserve = infinity;
  int conflicts = 0;
};

/// A robot that heads for an adversary, which heads for it, and is pushed at it.
Pushed pursue(const Barrier& filter, double w, int late, std::uint64_t seed) {
  Random random(seed);
  LateRobot robot(any_state(random, 0.0), late);
  Neighbour foe{.d_hard = 1.0, .speed_max = uniform(random, 0, 1.2), .age = late * control_period};
  foe.p = robot.p() + 5.0 * test::any_direction(random, seed % 2 == 0);
  Pushed found;
  VehicleInput wanted{};
  for (int k = 0; k < 1500; ++k) {
    const State then = robot.predicted();
    if (k % 40 == 0) wanted = uniform_array<4>(random, -1, 1);
    VehicleInput u = seed % 3 == 0 ? wanted : test::towards(then, foe.p);
    const BarrierResult result = filter.filter(then, {&foe, 1}, lowest, highest, u);
    found.reserve = std::min(found.reserve, result.reserve);
    found.conflicts += result.conflict;
    const Vec3<double> r = robot.p() - foe.p;
    const Vec2<double> push = k % 300 < 200 ? level(r, -w) : level(test::any_direction(random, false), w);
    robot.fly(u, push,
              [&](const Vec3<double>& p) { found.nearest = std::min(found.nearest, norm(p - foe.p)); });
    foe.p = foe.p + (control_period * foe.speed_max / norm(r)) * r;
  }
  return found;
}

TEST(ResidualAcceleration, WithinItsBoundAndWithLateCommandsNoAdversaryComesBelowTheHardDistance) {
  for (const auto& [w, late] : {std::pair(0.3, 0), std::pair(0.3, 15), std::pair(0.0, 15)}) {
    double uncounted = infinity;
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
      const Pushed found = pursue(counting(w, late), w, late, seed);
      EXPECT_GE(found.nearest, 1.0) << w << ", " << late << ", " << seed;
      EXPECT_GE(found.reserve, -1e-3) << w << ", " << late << ", " << seed;
      EXPECT_EQ(found.conflicts, 0) << w << ", " << late << ", " << seed;
      uncounted = std::min(uncounted, pursue(counting(0.0, late), w, late, seed).nearest);
    }
    if (w > 0) {
      EXPECT_LT(uncounted, 1.0) << "the push is felt";
    }
  }
}

TEST(ResidualAcceleration, OfTwoCooperativeRobotsIsThatOfBoth) {
  Random random(3);
  for (const int late : {0, 10}) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      const double w = 0.3;
      const Barrier filter = counting(w, late);
      std::array<LateRobot, 2> robots = {LateRobot(any_state(random, 0), late),
                                         LateRobot(any_state(random, 0), late)};
      robots[1].x[0] = 4.0, robots[1].x[1] = uniform(random, -1, 1);
      double nearest = infinity;
      for (int k = 0; k < 1200; ++k) {
        std::array<VehicleInput, 2> u;
        for (std::size_t i = 0; i < 2; ++i) {
          const State own = robots[i].predicted(), other = robots[1 - i].predicted();
          const Vec2<double> v = rotate<double>({other[3], other[4]}, {other[5], other[6]});
          const Neighbour n{.p = {other[0], other[1], other[2]},
                            .v = {v.x, v.y, 0},
                            .d_hard = 0.6,
                            .tie = i == 0 ? 1.0 : -1.0,
                            .behavior = Behavior::cooperative};
          u[i] = test::towards(own, n.p);
          const BarrierResult result = filter.filter(own, {&n, 1}, lowest, highest, u[i]);
          EXPECT_FALSE(result.conflict);
          EXPECT_GE(result.reserve, -1e-3);
        }
        const Vec2<double> push = level(robots[1].p() - robots[0].p(), w);
        std::array<std::vector<Vec3<double>>, 2> path;
        robots[0].fly(u[0], push, [&](const Vec3<double>& p) { path[0].push_back(p); });
        robots[1].fly(u[1], {-push.x, -push.y}, [&](const Vec3<double>& p) { path[1].push_back(p); });
        for (std::size_t j = 0; j < path[0].size(); ++j)
          nearest = std::min(nearest, norm(path[0][j] - path[1][j]));
      }
      EXPECT_GE(nearest, 0.6) << late << ", " << seed;
      EXPECT_LE(nearest, 1.5) << late << ", " << seed;
    }
  }
}

TEST(ResidualAcceleration, TowardsABoundOfTheWorldIsBrakedInTime) {
  Random random(4);
  for (const auto& [w, late] : {std::pair(0.4, 0), std::pair(0.4, 12)}) {
    for (int i = 0; i < 24; ++i) {
      const Barrier filter = counting(w, late, {.world = 4.0});
      LateRobot robot(any_state(random, 0), late);
      if (i % 2 == 0) robot.x[3] = 1, robot.x[4] = 0;  // no thrust but one brakes
      double farthest = 0.0;
      for (int k = 0; k < 800; ++k) {
        const State then = robot.predicted();
        VehicleInput u = test::towards(then, {9, 0, 1});
        EXPECT_FALSE(filter.filter(then, {}, lowest, highest, u).conflict);
        robot.fly(u, {k % 200 < 150 ? w : -w, 0},
                  [&](const Vec3<double>& p) { farthest = std::max(farthest, p.x); });
      }
      EXPECT_LE(farthest, 4.0 + 1e-4) << i;
      EXPECT_GE(farthest, 3.5) << i;
    }
  }
}

TEST(ResidualAcceleration, IsRefusedWherePlansHaveLessAndForRobotsThatDrive) {
  const std::string said = "barrier: residual_acceleration = ";
  EXPECT_EQ(refusal_of([] { counting(1.5, 0); }),
            said + "1.5 m/s^2, expected < 1.46, the acceleration of the plans of \"multirotor\"");
  EXPECT_EQ(refusal_of([] { counting(-0.1, 0); }), said + "-0.1, expected >= 0 m/s^2");
  EXPECT_EQ(refusal_of([] {
              Barrier(Unicycle{}, std::span(lowest).first(2), std::span(highest).first(2), control_period,
                      {.residual_acceleration = 0.1});
            }),
            said + "0.1 m/s^2, expected 0 with \"unicycle\", which stands by its model alone");
}

}  // namespace
}  // namespace sightline
