#include "sightline/safety/escape.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/period.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using test::control_period;

constexpr double drag = 0.5092;

Tube random_tube(Random& random, bool thrusts) {
  Tube tube{.r = random_point(random, 4.0), .w = {uniform(random, -2, 2), uniform(random, -2, 2)}};
  tube.r.z *= 0.5;
  tube.rho0 = uniform(random, 0.3, 1.2);
  tube.speed = random() % 4 == 0 ? 0.0 : uniform(random, 0.0, 1.5);
  if (random() % 3 == 0) {
    tube.drift = {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -0.5, 0.5)};
    tube.speed *= 0.3;
    tube.growth = uniform(random, 0.0, 0.05);
  }
  if (random() % 3 == 0) tube.spread = uniform(random, 0.0, 0.2);
  tube.beta = uniform(random, 1.0, 2.6);
  if (thrusts) {
    const double psi = uniform(random, -3.2, 3.2), g = uniform(random, 1.0, 1.5);
    tube.thrusts[0] = {g * std::cos(psi), g * std::sin(psi)};
    tube.thrusts[1] = {-g * std::sin(psi), g * std::cos(psi)};
    tube.thrust_count = 2;
  }
  return tube;
}

/// f_a(t), by quadrature of v' = -c v + a in place of the closed forms.
double least_by_integration(const Tube& tube, const Vec2<double>& a) {
  Vec2<double> q = {tube.r.x, tube.r.y}, v = tube.w;
  double E = 0.0, least = 1e9;
  constexpr double h = 1e-3;
  for (double t = 0; t < 8.0; t += h) {
    const double x = q.x - t * tube.drift.x, y = q.y - t * tube.drift.y;
    const double z = tube.r.z + std::clamp(tube.climb * t, -tube.room, tube.room) - t * tube.drift.z;
    const double rho = tube.rho0 + tube.speed * t + 0.5 * tube.growth * t * t + tube.spread * E;
    if (t >= control_period) least = std::min(least, std::sqrt(x * x + y * y + z * z) - rho);
    const Vec2<double> half = {v.x + 0.5 * h * (a.x - drag * v.x), v.y + 0.5 * h * (a.y - drag * v.y)};
    q = {q.x + h * half.x, q.y + h * half.y};
    v = {v.x + h * (a.x - drag * half.x), v.y + h * (a.y - drag * half.y)};
    E += h * std::exp(-drag * (t + 0.5 * h));
  }
  return least;
}

TEST(Escape, FindsTheLeastGapThatIntegrationFinds) {
  const EscapePlans plans(drag, control_period);
  Random random(1);
  for (int k = 0; k < 300; ++k) {
    Tube tube = random_tube(random, false);
    if (k % 2 == 0) {
      tube.climb = uniform(random, -1.0, 1.0);
      tube.room = uniform(random, 0.0, 3.0);
    }
    const double angle = uniform(random, -3.2, 3.2);
    const Vec2<double> a = {1.3 * std::cos(angle), 1.3 * std::sin(angle)};
    const Escape plan = plans.with(tube, a);
    // Within what a grid of 24 times can hide between two of them.
    EXPECT_GE(plan.later(), least_by_integration(tube, a) - 1e-3);
    EXPECT_LE(plan.later(), least_by_integration(tube, a) + 2e-2);
    EXPECT_NEAR(plan.later(), plans.touch(tube, a, plan.touches[0].time).gap, 1e-12);
    EXPECT_NEAR(plan.now, norm(tube.r) - tube.rho0, 1e-12);
    const Tube* const one = &tube;
    const EscapeFlight flight = {a, tube.climb, tube.room};
    Escape again;
    EXPECT_TRUE(plans.with({&one, 1}, flight, plan.reserve() - 1e-9, {&again, 1}));
    EXPECT_FALSE(plans.with({&one, 1}, flight, plan.reserve() + 0.1, {&again, 1}));
  }
}

TEST(Escape, TakesTheBestOfAllCorners) {
  const EscapePlans plans(drag, control_period);
  Random random(2);
  for (int k = 0; k < 20000; ++k) {
    const Tube tube = random_tube(random, true);
    double best = -1e9;
    for (const double i : {-1.0, 1.0}) {
      for (const double j : {-1.0, 1.0}) {
        const Vec2<double> a = {i * tube.thrusts[0].x + j * tube.thrusts[1].x,
                                i * tube.thrusts[0].y + j * tube.thrusts[1].y};
        best = std::max(best, plans.with(tube, a).later());
      }
    }
    EXPECT_GE(plans.best(tube).later(), best - 1.1e-3);
  }
}

TEST(Escape, TakesTheBestOfAllDirectionsOfADisc) {
  const EscapePlans plans(drag, control_period);
  Random random(3);
  int apart = 0;
  constexpr int cases = 2000;
  for (int k = 0; k < cases; ++k) {
    const Tube tube = random_tube(random, false);
    double best = -1e9;
    for (int i = 0; i < 360; ++i) {
      const double angle = std::numbers::pi * i / 180;
      best = std::max(best,
                      plans.with(tube, {tube.beta * std::cos(angle), tube.beta * std::sin(angle)}).later());
    }
    apart += plans.best(tube).later() < best - 5e-3;
  }
  EXPECT_LE(apart, cases / 100);
}

// The tube's argument: who follows the plan has no less after a step, wherever the neighbour went
// meanwhile.
TEST(Escape, LosesNothingByFollowingThePlan) {
  const EscapePlans plans(drag, control_period);
  Random random(4);
  for (int k = 0; k < 20000; ++k) {
    Tube tube = random_tube(random, true);
    tube.growth = tube.spread = 0.0;
    tube.drift = {};
    const Escape plan = plans.best(tube);
    const double e = std::exp(-drag * control_period), E = plans.E(control_period),
                 F = plans.F(control_period);
    const Vec3<double> any = random_point(random, 1.0);
    const double step = tube.speed * control_period / std::max(norm(any), 1e-9);
    Tube next = tube;
    next.r = {tube.r.x + E * tube.w.x + F * plan.a.x - step * any.x,
              tube.r.y + E * tube.w.y + F * plan.a.y - step * any.y, tube.r.z - step * any.z};
    next.w = {e * tube.w.x + E * plan.a.x, e * tube.w.y + E * plan.a.y};
    EXPECT_GE(plans.best(next).reserve(), plan.reserve() - 2.5e-3);
  }
}

TEST(Escape, OfThePartnerIsTheMirroredOne) {
  const EscapePlans plans(drag, control_period);
  Random random(5);
  for (int k = 0; k < 5000; ++k) {
    Tube tube = random_tube(random, false);
    tube.drift = {};
    if (k % 3 == 0) tube.r = {0, 0, k % 2 == 0 ? 0.0 : tube.r.z};
    if (k % 6 == 0) tube.w = {};
    Tube mirrored = tube;
    mirrored.r = -1.0 * tube.r;
    mirrored.w = {-tube.w.x, -tube.w.y};
    mirrored.tie = {-tube.tie.x, -tube.tie.y};
    const Escape a = plans.best(tube), b = plans.best(mirrored);
    EXPECT_EQ(a.later(), b.later());
    EXPECT_EQ(a.touches[0].time, b.touches[0].time);
    EXPECT_EQ(a.a.x, -b.a.x);
    EXPECT_EQ(a.touches[0].n.y, -b.touches[0].n.y);
    EXPECT_EQ(a.touches[0].n.z, -b.touches[0].n.z);
  }
}

bool same(const Touch& a, const Touch& b) {
  return a.gap == b.gap && a.time == b.time && a.n.x == b.n.x && a.n.y == b.n.y && a.n.z == b.n.z &&
         a.shape.e == b.shape.e && a.shape.E == b.shape.E && a.shape.F == b.shape.F && a.level == b.level &&
         a.slope == b.slope && a.curvature == b.curvature;
}

// Of as many tubes as fill a pack, and of fewer; every fourth on the robot itself, every fifth
// beyond help.
TEST(Escape, OfTubesSideBySideAreThoseOneByOne) {
  const EscapePlans plans(drag, control_period);
  Random random(6);
  for (int k = 0; k < 2000; ++k) {
    const bool thrusts = k % 2 == 0;
    std::vector<Tube> tubes(1 + random() % 20);
    std::vector<const Tube*> of;
    std::vector<Escape> escapes(tubes.size());
    std::vector<Escape*> to;
    for (Tube& tube : tubes) {
      of.push_back(&tube);
      to.push_back(&escapes[to.size()]);
      tube = random_tube(random, thrusts);
      tube.thrusts = tubes.front().thrusts;
      if (random() % 4 == 0) tube.r = {};
      if (random() % 5 == 0) tube.rho0 += 3.0;
    }
    plans.best(of, to);
    for (std::size_t i = 0; i < tubes.size(); ++i) {
      const Escape one = plans.best(tubes[i]), &beside = escapes[i];
      ASSERT_EQ(beside.now, one.now);
      ASSERT_EQ(beside.a.x, one.a.x);
      ASSERT_EQ(beside.a.y, one.a.y);
      ASSERT_EQ(beside.count, one.count);
      for (std::size_t j = 0; j < one.count; ++j) ASSERT_TRUE(same(beside.touches[j], one.touches[j]));
    }
    // A flight that climbs, and what it leaves of all.
    const EscapeFlight flight = {
        {uniform(random, -1, 1), uniform(random, -1, 1)}, uniform(random, -1, 1), 0.5};
    ASSERT_TRUE(plans.with(of, flight, -1e9, escapes));
    double least = 1e9;
    for (std::size_t i = 0; i < tubes.size(); ++i) {
      tubes[i].climb = flight.climb;
      tubes[i].room = flight.room;
      const Escape one = plans.with(tubes[i], flight.a);
      ASSERT_EQ(escapes[i].count, one.count);
      for (std::size_t j = 0; j < one.count; ++j) ASSERT_TRUE(same(escapes[i].touches[j], one.touches[j]));
      least = std::min(least, one.reserve());
    }
    const double wanted = least + uniform(random, -0.01, 0.05);
    const bool each = std::all_of(of.begin(), of.end(), [&](const Tube* const& one) {
      Escape again;
      return plans.with({&one, 1}, flight, wanted, {&again, 1});
    });
    ASSERT_EQ(plans.with(of, flight, wanted, escapes), each);
    ASSERT_TRUE(plans.with(of, flight, least - 1e-9, escapes));
  }
}

TEST(Escape, WithoutDragIsThatOfUniformAcceleration) {
  const EscapePlans plans(0.0, control_period);
  for (const double t : {0.0, 0.01, 0.5, 3.0}) {
    EXPECT_NEAR(plans.E(t), t, 1e-12);
    EXPECT_NEAR(plans.F(t), 0.5 * t * t, 1e-12);
  }
  // Closing in at 2 m/s from 3 m, 1 m/s^2 apart: 2 m are used up.
  const Tube tube{.r = {3, 0, 0}, .w = {-2, 0}, .beta = 1.0, .rho0 = 0.6};
  const Escape plan = plans.best(tube);
  EXPECT_NEAR(plan.later(), 0.4, 1e-6);
  EXPECT_NEAR(plan.touches[0].time, 2.0, 1e-3);
}

}  // namespace
}  // namespace sightline
