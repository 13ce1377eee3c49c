// Robots whose horizontal acceleration follows their commands with a lag, as a tilt does.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <numbers>
#include <utility>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/robots.hpp"
#include "sightline/safety/authority.hpp"
#include "sightline/safety/barrier_law.hpp"
#include "sightline/safety/escape.hpp"
#include "tests/support/adversary.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/counted_new.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::any_direction;
using test::control_period;
using test::highest;
using test::lowest;
using test::VehicleInput;

/// The law of LaggingHoverMultirotor in G, by the midpoint rule.
class LaggedVehicle {
 public:
  explicit LaggedVehicle(const LaggingHoverMultirotor& robot) : m(robot) {}

  template <class Seen>
  void fly(const VehicleInput& u, const Vec2<double>& wind, Seen&& seen) {
    constexpr int steps = 10;
    constexpr double h = control_period / steps;
    for (int k = 0; k < steps; ++k) {
      const LaggedVehicle half = moved(0.5 * h, *this, u, wind);
      *this = moved(h, half, u, wind);
      seen(p);
    }
  }
  std::vector<double> state() const {
    const Vec2<double> d = {std::cos(psi), std::sin(psi)}, v_V = rotate<double>({d.x, -d.y}, v);
    return {p.x, p.y, p.z, d.x, d.y, v_V.x, v_V.y, a.x, a.y, climb, rate};
  }

  LaggingHoverMultirotor m;
  Vec3<double> p{0, 0, 2};
  Vec2<double> v, a;  // velocity in G, acceleration of the tilt in V
  double psi = 0.0, climb = 0.0, rate = 0.0;

 private:
  LaggedVehicle moved(double h, const LaggedVehicle& at, const VehicleInput& u, const Vec2<double>& w) const {
    const double rise = (m.b_z * u[2] - at.climb) / m.tau_z, lift = 1.0 + rise / gravity;
    const Vec2<double> push = rotate<double>({std::cos(at.psi), std::sin(at.psi)}, at.a);
    LaggedVehicle next = *this;
    next.p = p + h * Vec3<double>{at.v.x, at.v.y, at.climb};
    next.v = {v.x + h * (m.a_f * at.v.x + lift * push.x + w.x),
              v.y + h * (m.a_f * at.v.y + lift * push.y + w.y)};
    next.a = {a.x + h / m.tau * (m.b_f * u[0] - at.a.x), a.y + h / m.tau * (-m.b_s * u[1] - at.a.y)};
    next.psi += h * at.rate;
    next.climb += h * rise;
    next.rate += h / m.tau_psi * (m.b_psi * u[3] - at.rate);
    return next;
  }
};

LaggingHoverMultirotor any_vehicle(Random& random) {
  LaggingHoverMultirotor m;
  m.b_z = uniform(random, 0.5, 1.2);
  m.b_psi = uniform(random, 0.5, 2.0);
  m.a_f = m.a_s = -uniform(random, 0.1, 0.6);
  m.b_f = uniform(random, 1.4, 2.5);
  m.b_s = uniform(random, 1.4, 2.5);
  m.tau = uniform(random, 0.05, 0.25);
  m.tau_z = uniform(random, 0.1, 0.3);
  m.tau_psi = uniform(random, 0.05, 0.2);
  return m;
}

LaggedVehicle any_state(const LaggingHoverMultirotor& m, Random& random) {
  LaggedVehicle robot(m);
  robot.psi = uniform(random, -3.2, 3.2);
  robot.v = {uniform(random, -2, 2), uniform(random, -2, 2)};
  robot.a = {m.b_f * uniform(random, -1, 1), m.b_s * uniform(random, -1, 1)};
  robot.climb = m.b_z * uniform(random, -1, 1), robot.rate = m.b_psi * uniform(random, -1, 1);
  return robot;
}

/// The same vehicle without its lags.
HoverMultirotor at_once(const LaggingHoverMultirotor& m) {
  return {.b_z = m.b_z, .b_psi = m.b_psi, .a_f = m.a_f, .b_f = m.b_f, .a_s = m.a_s, .b_s = m.b_s};
}

/// Puts a neighbour where its reserve is `wanted`, along a direction.
void place(Neighbour& n, const Barrier& filter, const LaggedVehicle& robot, const Vec3<double>& along,
           double wanted) {
  const std::vector<double> x = robot.state();
  double near = 0.1, far = 60.0;
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (near + far);
    n.p = robot.p + middle * along;
    (filter.reserve(x, n) < wanted ? near : far) = middle;
  }
  n.p = robot.p + far * along;
}

TEST(ThrustLag, TheResponsesAreThoseOfIntegrationAlsoWhereLagAndDragAreAlike) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const double tau = uniform(random, 0.02, 2.0);
    const std::array<double, 5> drags = {0.0, uniform(random, 0.0, 2.0), 1 / tau, 1 / tau * (1 + 1e-6),
                                         1 / tau + 2e-4};
    const double c = drags[static_cast<std::size_t>(i) % drags.size()];
    const EscapePlans plans(c, control_period, tau);
    const double end = uniform(random, 0.0, 3.0), h = end / 2000;
    // Position and velocity for a velocity, a present and a commanded acceleration of 1, by RK4.
    std::array<std::array<double, 3>, 3> z = {{{0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};
    for (std::size_t of = 0; of < 3; ++of) {
      std::array<double, RungeKuttaScratch::rows_needed * 3> rows;
      for (int k = 0; k < 2000; ++k) {
        rk4_step(
            [&](std::span<const double> x, std::span<double> rate) {
              rate[0] = x[1], rate[1] = x[2] - c * x[1], rate[2] = ((of == 2 ? 1 : 0) - x[2]) / tau;
            },
            z[of], h, {rows});
      }
    }
    const EscapeShape at = plans.shape(end);
    EXPECT_NEAR(at.E, z[0][0], 2e-6 * end) << c << ", " << tau << ", " << end;
    EXPECT_NEAR(at.e, z[0][1], 1e-9);
    EXPECT_NEAR(at.L, z[1][0], 1e-7 + 2e-6 * end * end) << c << ", " << tau << ", " << end;
    EXPECT_NEAR(at.L_rate, z[1][1], 1e-6) << c << ", " << tau << ", " << end;
    EXPECT_NEAR(at.F, z[2][0], 1e-7 + 2e-6 * end * end) << c << ", " << tau << ", " << end;
    EXPECT_NEAR(at.F_rate, z[2][1], 1e-6 + 2e-6 * end) << c << ", " << tau << ", " << end;
  }
}

TEST(ThrustLag, IsFoundWithTheOthersInTheModel) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const LaggingHoverMultirotor m = any_vehicle(random);
    const Authority can = authority_of(m, lowest, highest);
    EXPECT_NEAR(can.thrust_lag, m.tau, 1e-5);
    EXPECT_NEAR(can.turn_lag, m.tau_psi, 1e-5);
    EXPECT_NEAR(can.climb_lag, m.tau_z, 1e-4);
    EXPECT_NEAR(can.drag, -m.a_f, 1e-6);
    EXPECT_NEAR(can.lift, 1 / gravity, 1e-5);
    EXPECT_NEAR(can.acceleration, std::min(m.b_f, m.b_s), 1e-5);
    EXPECT_NEAR(can.thrust_most, std::hypot(m.b_f, m.b_s), 1e-5);
    EXPECT_NEAR(can.turn, 2 * m.b_psi / m.tau_psi, 1e-3);
    EXPECT_EQ(can.misfit, 0.0);
  }
  LaggingHoverMultirotor uneven;
  uneven.a_s = 2 * uneven.a_f;
  EXPECT_GT(authority_of(uneven, lowest, highest).misfit, 1e-2);
  uneven.a_f = -2.0, uneven.a_s = -2.0, uneven.tau = 0.6;
  EXPECT_EQ(refusal_of([&] { Barrier(uneven, lowest, highest, control_period); }),
            "barrier: \"hover_multirotor\" has a lag of 0.6 s and a drag of 2 /s, expected a product <= 0.9");
}

TEST(ThrustLag, TheReserveIsThatOfTheBestFlightThatTheVehicleCanBegin) {
  Random random(3);
  for (int i = 0; i < 40; ++i) {
    const LaggingHoverMultirotor m = any_vehicle(random);
    LaggedVehicle robot = any_state(m, random);
    robot.climb = robot.rate = 0.0;
    Neighbour n{.d_hard = 0.6, .speed_max = uniform(random, 0, 1)};
    n.p = robot.p + uniform(random, 1.0, 4.0) * any_direction(random, true);
    const double b = 0.9 * std::min(m.b_f, m.b_s);
    double best = -infinity;
    for (int k = 0; k < 72; ++k) {
      const double angle = std::numbers::pi / 36 * k;
      const Vec2<double> a_V = rotate<double>({std::cos(robot.psi), -std::sin(robot.psi)},
                                              {b * std::cos(angle), b * std::sin(angle)});
      LaggedVehicle flies = robot;
      double least = norm(flies.p - n.p), t = 0.0;
      for (int period = 0; period < 800; ++period) {
        flies.fly({a_V.x / m.b_f, -a_V.y / m.b_s, 0, 0}, {}, [&](const Vec3<double>& p) {
          t += control_period / 10;
          least = std::min(least, norm(p - n.p) - n.speed_max * t);
        });
      }
      best = std::max(best, least - n.d_hard - 0.002);
    }
    const double reserve = Barrier(m, lowest, highest, control_period).reserve(robot.state(), n);
    EXPECT_GE(reserve, best - 1e-3) << i;
    EXPECT_LE(reserve, best + 5e-3) << i;
  }
}

Tube any_tube(Random& random) {
  return {.r = random_point(random, 3.0),
          .w = {uniform(random, -2, 2), uniform(random, -2, 2)},
          .s = {uniform(random, -2, 2), uniform(random, -2, 2)},
          .beta = uniform(random, 1.0, 2.5),
          .rho0 = uniform(random, 0.3, 1.2),
          .speed = uniform(random, 0.0, 1.5),
          .spread = uniform(random, 0.0, 0.2)};
}

TEST(ThrustLag, NoOtherDirectionOfThePlanLeavesMore) {
  Random random(6);
  double lost = 0.0;
  for (int i = 0; i < runs(20000, 40); ++i) {
    const double c = uniform(random, 0.05, 0.6), tau = uniform(random, 0.05, 0.3);
    const EscapePlans plans(c, control_period, tau);
    const Tube tube = any_tube(random);
    const double best = plans.best(tube).reserve();
    // Elsewhere a robot has room.
    if (std::abs(best) > 0.05) continue;
    for (int k = 0; k < 360; ++k) {
      const double angle = std::numbers::pi / 180 * k;
      const Vec2<double> a = {tube.beta * std::cos(angle), tube.beta * std::sin(angle)};
      lost = std::max(lost, plans.with(tube, a).reserve() - best);
    }
  }
  EXPECT_LE(lost, 2e-5);
}

TEST(ThrustLag, WhatAPlanKeepsItKeepsAtAllTimesAndHardlyMoreCouldBeProven) {
  Random random(8);
  int kept = 0;
  for (int i = 0; i < runs(20000, 40); ++i) {
    const double c = uniform(random, 0.05, 0.6), tau = i % 8 == 0 ? 0.0 : uniform(random, 0.05, 0.3);
    const EscapePlans plans(c, control_period, tau);
    const Tube tube = any_tube(random);
    const double angle = uniform(random, -3.2, 3.2);
    const Vec2<double> a = i % 2 == 0
                               ? plans.best(tube).a
                               : Vec2<double>{tube.beta * std::cos(angle), tube.beta * std::sin(angle)};
    double least = infinity;
    for (double t = 0.0; t < 40.0; t += t < 8.0 ? 0.005 : 0.5)
      least = std::min(least, plans.touch(tube, a, t).gap);
    EXPECT_FALSE(plans.keeps(tube, a, least + 1e-9)) << i;
    if (i % 2 == 1) continue;
    EXPECT_TRUE(plans.keeps(tube, a, least - 1e-4)) << i;
    ++kept;
  }
  EXPECT_GT(kept, 0);
}

TEST(ThrustLag, APlanThatABodyOutrunsAfterItsLastTimeIsNotKept) {
  const EscapePlans plans(0.5, control_period, 0.15);
  // The plan approaches 4 m/s.
  for (const auto& [speed, keeps] : {std::pair(3.8, true), {4.2, false}}) {
    const Tube tube{.r = {20, 0, 0}, .beta = 2.0, .rho0 = 0.5, .speed = speed};
    EXPECT_GT(plans.with(tube, {2.0, 0.0}).reserve(), 1.0);
    EXPECT_EQ(plans.keeps(tube, {2.0, 0.0}, 0.0), keeps) << speed;
  }
}

/// Adds what a push of w along n since a measurement moves a state that is predicted over a delay.
void push(LaggedVehicle& robot, const EscapePlans& plans, double w, double delay, const Vec2<double>& n) {
  const double p = w * (plans.F(delay + control_period) - plans.F(delay)),
               v = w * (plans.E(delay + control_period) - plans.E(delay));
  robot.p = robot.p + p * Vec3<double>{n.x, n.y, 0.0};
  robot.v = {robot.v.x + v * n.x, robot.v.y + v * n.y};
}

/// Moves a neighbour towards a robot for a period.
void come_nearer(Neighbour& n, const LaggedVehicle& robot) {
  const Vec3<double> r = robot.p - n.p;
  n.p = n.p + (control_period * n.speed_max / norm(r)) * r;
}

/// What a plan of acceleration a leaves of the distance to a body at `other`, by the formulas of
/// docs/safety.md, from sample `from` on.
double left_by_plan(const LaggedVehicle& robot, const EscapePlans& plans, const Vec2<double>& a,
                    const Vec3<double>& other, double speed, double w, double delay, int from) {
  const LaggingHoverMultirotor& m = robot.m;
  const double c = -m.a_f, most = std::hypot(m.b_f, m.b_s), b = std::min(m.b_f, m.b_s);
  const auto impulse = [&](double tau) { return tau / (1 - c * tau); };
  const double V = most * impulse(m.tau_z) / (gravity * m.tau_z) * std::abs(robot.climb) +
                   impulse(m.tau) * impulse(m.tau_psi) *
                       (most + b * m.tau_psi / m.tau * (std::exp(control_period / m.tau_psi) - 1)) *
                       std::abs(robot.rate);
  const Vec2<double> push = rotate<double>({std::cos(robot.psi), std::sin(robot.psi)}, robot.a);
  const Vec3<double> r = robot.p - other;
  double least = infinity;
  for (int k = from; k < 800; ++k) {
    const double t = k * control_period;
    const EscapeShape at = plans.shape(t);
    const Vec3<double> q = {r.x + at.E * robot.v.x + at.L * push.x + at.F * a.x,
                            r.y + at.E * robot.v.y + at.L * push.y + at.F * a.y, r.z + m.tau_z * robot.climb};
    least = std::min(
        least, norm(q) - speed * t - m.tau_z * std::abs(robot.climb) - V * at.E - w * plans.F(delay + t));
  }
  return least;
}

TEST(ThrustLag, ThePlansOwnCommandKeepsWhatThePlanLeaves) {
  Random random(9);
  double lost = 0.0;
  for (int i = 0; i < runs(20000, 40); ++i) {
    const LaggingHoverMultirotor m = any_vehicle(random);
    LaggedVehicle robot = any_state(m, random);
    const double w = i % 2 == 0 ? 0.0 : 0.2, delay = i % 4 < 2 ? 0.0 : 0.08;
    const EscapePlans plans(-m.a_f, control_period, m.tau);
    Neighbour n{.p = robot.p + uniform(random, 0.5, 4.0) * any_direction(random, true),
                .speed_max = uniform(random, 0, 1.5)};
    const double angle = uniform(random, -3.2, 3.2), b = 0.9 * std::min(m.b_f, m.b_s);
    const Vec2<double> a = {b * std::cos(angle), b * std::sin(angle)};
    const double before = left_by_plan(robot, plans, a, n.p, n.speed_max, w, delay, 1);
    const Vec2<double> a_V = rotate<double>({std::cos(robot.psi), -std::sin(robot.psi)}, a);
    robot.fly({a_V.x / m.b_f, -a_V.y / m.b_s, 0, 0}, {}, [](const Vec3<double>&) {});
    const double to = uniform(random, -3.2, 3.2);
    push(robot, plans, w, delay, {std::cos(to), std::sin(to)});
    come_nearer(n, robot);
    lost = std::max(lost, before - left_by_plan(robot, plans, a, n.p, n.speed_max, w, delay, 0));
  }
  std::printf("most lost %.9f m\n", lost);
  EXPECT_LE(lost, 1e-6);
}

TEST(ThrustLag, ThePlansOwnCommandKeepsItsDirectionInTheVehicleWhileThatTurns) {
  Random random(10);
  for (int i = 0; i < 20; ++i) {
    const LaggingHoverMultirotor m = any_vehicle(random);
    const BarrierLaw law(m, authority_of(m, lowest, highest), control_period, {});
    const LaggedVehicle robot = any_state(m, random);
    const std::vector<double> x = robot.state();
    VehicleInput u{};
    const double angle = uniform(random, -3.2, 3.2);
    const Vec2<double> a = {law.b * std::cos(angle), law.b * std::sin(angle)},
                       a_V = rotate<double>({std::cos(robot.psi), -std::sin(robot.psi)}, a);
    const Sight<double> self = law.settled(law.model.sight(x.data(), u.data()));
    law.reach_for(x, law.outcome_of_held(self, law.next(x, u), a), lowest, highest, u);
    const VehicleInput expected = {a_V.x / m.b_f, -a_V.y / m.b_s, 0, 0};
    for (std::size_t k = 0; k < u.size(); ++k) EXPECT_NEAR(u[k], expected[k], 1e-5) << i << ", " << k;
  }
}

/// A state at which the search finds a plan that is 4 mm worse than the best.
TEST(ThrustLag, APlanThatTheSearchMissesIsKeptFromThePeriodBefore) {
  LaggingHoverMultirotor m;
  m.a_f = m.a_s = -0.18167784612812654;
  m.tau = 0.19439462361223803, m.tau_z = 0.2, m.tau_psi = 0.1;
  m.b_f = m.b_s = 1.3522499745988796 / 0.9;
  const Barrier filter(m, lowest, highest, control_period);
  LaggedVehicle robot(m);
  robot.v = {-1.938922981080814, 1.1204827069954759};
  robot.a = {1.9988766395392239, 0.70676242151607083};
  Neighbour n{.d_hard = 0.57, .speed_max = 0.46579893061286526};
  n.p = robot.p - Vec3<double>{0.23319837651125574, 0.06713790637868744, -0.6057053218325974};
  const auto filtered = [&](EvasiveManeuver& kept, VehicleInput& u) {
    return filter.filter(robot.state(), {&n, 1}, lowest, highest, u, kept);
  };
  const auto put = [&](double reserve) { n.d_hard += filter.reserve(robot.state(), n) - reserve; };
  put(-0.0025);
  EXPECT_FALSE(filter.keeps(robot.state(), n));
  // A plan that is no better is not kept either.
  double best = -infinity;
  Vec2<double> along;
  for (int k = 0; k < 720; ++k) {
    EvasiveManeuver kept{
        .plan = {std::cos(std::numbers::pi / 360 * k), std::sin(std::numbers::pi / 360 * k)}};
    VehicleInput u = {-1, 1, 0, 0};
    const double reserve = filtered(kept, u).reserve;
    if (dot(kept.plan, kept.plan) > 0 && reserve > best) best = reserve, along = kept.plan;
  }
  EXPECT_GT(best, 0.001);
  // Where the bound proves no command, the robot flies the plan's own.
  n.d_hard += best + 0.001005;
  EvasiveManeuver kept{.plan = along};
  VehicleInput u = {-1, 1, 0, 0};
  const BarrierResult result = filtered(kept, u);
  EXPECT_NEAR(u[0], 0.9 * along.x, 1e-6);
  EXPECT_NEAR(u[1], -0.9 * along.y, 1e-6);
  EXPECT_NEAR(dot(kept.plan, along), 1.0, 1e-12);
  EXPECT_FALSE(result.conflict);
  // A body that came nearer than was assumed ends it.
  n.d_hard += 1e-4;
  (void)filtered(kept, u);
  EXPECT_EQ(dot(kept.plan, kept.plan), 0.0);
}

TEST(ThrustLag, ATiltBeyondThatOfAnyCommandLeavesNoProvenPlan) {
  const LaggingHoverMultirotor m;
  const Barrier filter(m, lowest, highest, control_period);
  LaggedVehicle robot(m);
  const Neighbour n{.p = robot.p + Vec3<double>{9, 0, 0}, .d_hard = 0.5, .speed_max = 0.0};
  robot.a = {m.b_f, m.b_s};
  EXPECT_TRUE(filter.keeps(robot.state(), n));
  robot.a = {1.01 * m.b_f, m.b_s};
  EXPECT_FALSE(filter.keeps(robot.state(), n));
}

TEST(ThrustLag, ThePlanOfThePeriodBeforeIsFlownWhereNoneIsProvenThoughTheBodyIsFar) {
  LaggingHoverMultirotor m;
  m.a_f = m.a_s = -0.5;
  const Barrier filter(m, lowest, highest, control_period);
  const LaggedVehicle robot(m);
  const double outrun = filter.acceleration() / -m.a_f;
  Neighbour n{.p = robot.p + Vec3<double>{60, 0, 0}, .d_hard = 0.5, .speed_max = 0.6 * outrun};
  const auto flown = [&] {
    EvasiveManeuver kept{.plan = {-1, 0}};
    VehicleInput u{};
    (void)filter.filter(robot.state(), {&n, 1}, lowest, highest, u, kept);
    return u[0];
  };
  EXPECT_EQ(flown(), 0.0);
  n.speed_max = 1.1 * outrun;
  EXPECT_FALSE(filter.keeps(robot.state(), n));
  EXPECT_NEAR(flown(), -0.9, 1e-6);
}

/// One sample ahead of states at the edge of the safe set, with hostile commands, the worst
/// neighbour and pushes.
TEST(ThrustLag, NoSampleLeavesTheSafeSet) {
  Random random(4);
  double worst = infinity, least = infinity, violation = 0.0;
  int unproven = 0;
  for (int i = 0; i < runs(4000, 16); ++i) {
    const LaggingHoverMultirotor m = any_vehicle(random);
    const double w = i % 2 == 0 ? 0.0 : 0.2, delay = i % 4 < 2 ? 0.0 : 0.08;
    const EscapePlans plans(-m.a_f, control_period);
    const Barrier filter(m, lowest, highest, control_period,
                         {.residual_acceleration = w, .command_delay = delay});
    for (int k = 0; k < 10; ++k) {
      LaggedVehicle robot = any_state(m, random);
      if (k == 0) robot.rate = 0.0;
      Neighbour n{.d_hard = uniform(random, 0.4, 1.2), .speed_max = uniform(random, 0.0, 1.5), .age = delay};
      place(n, filter, robot, any_direction(random, true), k % 2 == 0 ? 0.0 : uniform(random, 0.0, 0.05));
      VehicleInput u = k % 3 == 0 ? test::towards({0, 0, 2, std::cos(robot.psi), std::sin(robot.psi)}, n.p)
                                  : uniform_array<4>(random, -1, 1);
      if (k % 3 == 1) u[2] = k % 2 == 0 ? 1 : -1, u[3] = random() % 2 == 0 ? 1 : -1;
      EvasiveManeuver kept;
      const BarrierResult before = filter.filter(robot.state(), {&n, 1}, lowest, highest, u, kept);
      unproven += !filter.keeps(robot.state(), n) || dot(kept.plan, kept.plan) == 0;
      robot.fly(u, {}, [](const Vec3<double>&) {});
      const Vec3<double> r = robot.p - n.p;
      const double far = norm(r.x, r.y),
                   to = k % 4 == 3 ? uniform(random, -3, 3) : std::atan2(-r.y / far, -r.x / far);
      push(robot, plans, w, delay, {std::cos(to), std::sin(to)});
      come_nearer(n, robot);
      u = {};
      const BarrierResult after = filter.filter(robot.state(), {&n, 1}, lowest, highest, u, kept);
      unproven += dot(kept.plan, kept.plan) == 0;
      violation = std::max({violation, before.violation, after.violation});
      least = std::min(least, after.reserve);
      worst = std::min(worst, after.reserve - (1 - filter.options().rate * control_period) * before.reserve);
    }
  }
  std::printf(
      "least reserve %.7f m, and less what was required %.7f m, largest violation %.7f m, not proven %d\n",
      least, worst, violation, unproven);
  EXPECT_EQ(unproven, 0);
  EXPECT_GE(least, -1e-3);
  EXPECT_LE(violation, 1e-4);
}

struct LaggedDuel {
  double nearest = infinity, reserve = infinity, lowest = infinity;  // nearest: less d_hard [m]
  int conflicts = 0, unproven = 0;                                   // periods
  std::int64_t allocations = 0;
};

/// A vehicle whose commands take effect `late` periods after the measurement, from the edge of what
/// `guard` calls safe. An adversary heads for it, for where it will be, or anywhere. `at_once`: the
/// filter omits the lags.
LaggedDuel duel(const Barrier& guard, const Barrier& filter, bool at_once, const LaggingHoverMultirotor& m,
                double w, int late, std::uint64_t seed) {
  Random random(seed);
  LaggedVehicle robot = any_state(m, random);
  std::deque<VehicleInput> on_the_way(static_cast<std::size_t>(late));
  const auto predicted = [&] {
    LaggedVehicle then = robot;
    for (const VehicleInput& u : on_the_way) then.fly(u, {}, [](const Vec3<double>&) {});
    return then;
  };
  Neighbour foe{.d_hard = uniform(random, 0.4, 1.2), .speed_max = uniform(random, 0, 1.5)};
  foe.age = late * control_period;
  place(foe, guard, predicted(), any_direction(random, seed % 2 == 0), uniform(random, 0.0, 0.2));
  const bool spins = seed % 3 == 0, climbs = seed % 5 == 0;
  const int hold = 1 + static_cast<int>(random() % 40), nominal = static_cast<int>(random() % 4),
            pursuit = static_cast<int>(random() % 3);
  LaggedDuel found;
  EvasiveManeuver kept;
  VehicleInput wanted{};
  Vec3<double> along{};
  for (int k = 0; k < 600; ++k) {
    const LaggedVehicle then = predicted();
    if (k % hold == 0) wanted = uniform_array<4>(random, -1, 1);
    if (k % hold == 0 && nominal == 1)
      for (double& command : wanted) command = command < 0 ? -1 : 1;
    VehicleInput u = wanted;
    if (nominal > 1) {
      u = test::towards({then.p.x, then.p.y, then.p.z, std::cos(then.psi), std::sin(then.psi)}, foe.p);
      if (spins) u[3] = k / hold % 2 == 0 ? 1 : -1;
      if (climbs) u[2] = k / hold % 2 == 0 ? 1 : -1;
    }
    std::vector<double> x = then.state();
    if (at_once) x.resize(HoverMultirotor::nx);
    const std::int64_t before = allocations_here();
    const BarrierResult result = filter.filter(x, {&foe, 1}, lowest, highest, u, kept);
    found.allocations += allocations_here() - before;
    found.reserve = std::min(found.reserve, result.reserve);
    found.conflicts += result.conflict;
    found.unproven += dot(kept.plan, kept.plan) == 0;
    const Vec3<double> r = robot.p - foe.p;
    const double ahead = pursuit == 1 ? norm(r) / std::max(foe.speed_max, 0.2) : 0.0;
    const Vec3<double> aim = r + ahead * Vec3<double>{robot.v.x, robot.v.y, 0.0};
    if (pursuit < 2 || k % hold == 0)
      along = pursuit == 2 && random() % 2 == 0 ? any_direction(random, true) : (1 / norm(aim)) * aim;
    const Vec3<double> from = foe.p;
    double t = 0.0;
    on_the_way.push_back(u);
    const double far = norm(r.x, r.y);
    robot.fly(on_the_way.front(), {-w * r.x / far, -w * r.y / far}, [&](const Vec3<double>& p) {
      t += control_period / 10;
      if (k < late) return;  // before the first command acts
      found.nearest = std::min(found.nearest, norm(p - (from + (t * foe.speed_max) * along)) - foe.d_hard);
      found.lowest = std::min(found.lowest, p.z);
    });
    on_the_way.pop_front();
    foe.p = from + (control_period * foe.speed_max) * along;
  }
  return found;
}

TEST(ThrustLag, CountedByTheBarrierNoAdversaryComesBelowTheHardDistance) {
  struct Kind {
    double w;
    int late;
  };
  for (const auto& [w, late] : {Kind{0.0, 0}, Kind{0.2, 0}, Kind{0.0, 8}, Kind{0.2, 8}}) {
    double worst = infinity, reserve = infinity, uncounted = infinity;
    int below = 0, below_uncounted = 0, conflicts = 0;
    const int count = runs(2000, 40);
    for (int i = 0; i < count; ++i) {
      const auto seed = static_cast<std::uint64_t>(i);
      Random random(seed);
      const LaggingHoverMultirotor m = i % 3 == 0 ? LaggingHoverMultirotor::x500() : any_vehicle(random);
      const BarrierOptions options{
          .authority = 1.0, .residual_acceleration = w, .command_delay = late * control_period};
      const Barrier filter(m, lowest, highest, control_period, options);
      const LaggedDuel on = duel(filter, filter, false, m, w, late, seed);
      EXPECT_GE(on.nearest, 0.0) << w << ", " << late << ", " << seed;
      EXPECT_EQ(on.conflicts, 0) << w << ", " << late << ", " << seed;
      EXPECT_EQ(on.unproven, 0) << w << ", " << late << ", " << seed;
      EXPECT_EQ(on.allocations, 0);
      below += on.nearest<0, conflicts += on.conflicts> 0;
      worst = std::min(worst, on.nearest), reserve = std::min(reserve, on.reserve);
      const Barrier omits(at_once(m), lowest, highest, control_period, options);
      const LaggedDuel without = duel(filter, omits, true, m, w, late, seed);
      below_uncounted += without.nearest < 0;
      uncounted = std::min(uncounted, without.nearest);
    }
    std::printf(
        "residual %.1f m/s^2, delay %.2f s: runs %d, below d_hard %d, worst %+.4f m, least reserve %.6f m; "
        "lags "
        "omitted: below %d, worst %+.4f m\n",
        w, late * control_period, count, below, worst, reserve, below_uncounted, uncounted);
    EXPECT_GE(reserve, -1e-3);
    EXPECT_GT(below_uncounted, count / 10);
  }
}

TEST(ThrustLag, ABoundOfTheWorldIsKeptAlsoByAVehicleThatSpinsAndClimbs) {
  Random random(5);
  for (int i = 0; i < runs(2000, 50); ++i) {
    const LaggingHoverMultirotor m = any_vehicle(random);
    const Barrier filter(m, lowest, highest, control_period, {.floor = 0.5, .world = 6.0});
    LaggedVehicle robot(m);
    robot.psi = uniform(random, -3.2, 3.2);
    const bool climbs = i % 4 < 2;
    double farthest = 0.0, lowest_height = infinity;
    for (int k = 0; k < 800; ++k) {
      VehicleInput u =
          test::towards({robot.p.x, robot.p.y, robot.p.z, std::cos(robot.psi), std::sin(robot.psi)},
                        {9.0, 0.0,
                         !climbs           ? robot.p.z
                         : k / 50 % 2 == 0 ? 9.0
                                           : 0.0});
      if (i % 2 == 0) u[3] = k / 30 % 2 == 0 ? 1 : -1;
      const BarrierResult result = filter.filter(robot.state(), {}, lowest, highest, u);
      EXPECT_LE(result.violation, climbs ? 1e-3 : 1e-5) << i << ", " << k;
      EXPECT_TRUE(climbs || !result.conflict) << i << ", " << k;
      robot.fly(u, {}, [&](const Vec3<double>& p) {
        farthest = std::max(farthest, p.x), lowest_height = std::min(lowest_height, p.z);
      });
    }
    EXPECT_LE(farthest, 6.0) << i;
    EXPECT_GE(farthest, 5.5) << i;
    EXPECT_GE(lowest_height, 0.5 - 1e-4) << i;
  }
}

TEST(ThrustLag, APushTowardsABoundOfTheWorldDoesNotExceedIt) {
  const LaggingHoverMultirotor m = LaggingHoverMultirotor::x500();
  for (const auto& [w, aim] : {std::pair(0.0, 4.0), {0.2, 4.0}, {0.5, 4.0}, {0.2, 9.0}, {0.5, 9.0}}) {
    const Barrier filter(m, lowest, highest, control_period, {.world = 4.0, .residual_acceleration = w});
    LaggedVehicle robot(m);
    double farthest = 0.0;
    for (int k = 0; k < 1500; ++k) {
      VehicleInput u = test::towards({robot.p.x, robot.p.y, robot.p.z, 1, 0}, {aim, 0.0, 2.0});
      const BarrierResult result = filter.filter(robot.state(), {}, lowest, highest, u);
      EXPECT_LE(result.violation, aim > 4.0 ? 1e-3 : 1e-5) << w << ", " << aim << ", " << k;
      robot.fly(u, {w, 0}, [&](const Vec3<double>& p) { farthest = std::max(farthest, p.x); });
    }
    std::printf("residual %.1f m/s^2: %+.6f m beyond the bound\n", w, farthest - 4.0);
    EXPECT_LE(farthest, 4.0 + 1e-3) << w << ", " << aim;
    EXPECT_GE(farthest, 3.9) << w << ", " << aim;
  }
}

TEST(ThrustLag, ABodyFarAwayDoesNotHinderAYawThatTurnsBack) {
  const LaggingHoverMultirotor m = LaggingHoverMultirotor::x500();
  const Barrier filter(m, lowest, highest, control_period);
  for (const double distance : {2.0, 50.0}) {
    const Neighbour other{.p = {distance, 0, 2}, .d_hard = 1.0, .speed_max = 1.0};
    LaggedVehicle robot(m);
    for (int k = 0; k < 300; ++k) {
      const VehicleInput wanted = {0.3, -0.2, 0, k / 30 % 2 == 0 ? 1.0 : -1.0};
      VehicleInput u = wanted;
      const BarrierResult result = filter.filter(robot.state(), {&other, 1}, lowest, highest, u);
      EXPECT_EQ(result.neighbour, 0) << k;
      if (distance > 2.0) {
        EXPECT_EQ(u, wanted) << k;
      }
      robot.fly(u, {}, [](const Vec3<double>&) {});
    }
  }
}

// A manoeuvre gives up the separate plans, whose rows would turn its thrust.
TEST(ThrustLag, AnEvasiveManeuverIsFlownWithItsWholeThrust) {
  const LaggingHoverMultirotor m = LaggingHoverMultirotor::x500();
  const Barrier filter(m, lowest, highest, control_period, {.floor = 1.7, .ceiling = 2.3});
  const double b = authority_of(m, lowest, highest).acceleration;
  Random random(7);
  int flown = 0;
  for (int i = 0; i < 20; ++i) {
    LaggedVehicle robot = any_state(m, random);
    robot.rate = 0.0;
    std::vector<Neighbour> ring;
    for (int n = 0; n < 5; ++n) {
      const double angle = 2 * std::numbers::pi / 5 * n + uniform(random, 0, 0.5);
      const Vec2<double> at = {2.5 * std::cos(angle), 2.5 * std::sin(angle)};
      ring.push_back({.p = {at.x, at.y, uniform(random, 1.7, 2.3)}, .d_hard = 0.6, .speed_max = 1.0});
    }
    EvasiveManeuver maneuver;
    for (int k = 0; k < 200; ++k) {
      VehicleInput u{};
      (void)filter.filter(robot.state(), ring, lowest, highest, u, maneuver);
      const double thrust = norm(m.b_f * u[0], m.b_s * u[1]);
      if (maneuver.taken && thrust > 1e-3) {
        EXPECT_NEAR(thrust, b, 1e-3 * b) << i << ", " << k;
        ++flown;
      }
      robot.fly(u, {}, [](const Vec3<double>&) {});
      for (Neighbour& n : ring) {
        const Vec3<double> r = robot.p - n.p;
        n.p = n.p + (control_period * n.speed_max / norm(r)) * r;
      }
    }
  }
  EXPECT_GE(flown, 100);
}

}  // namespace
}  // namespace sightline
