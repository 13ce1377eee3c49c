#include "sightline/safety/evasive_maneuver.hpp"

#include <gtest/gtest.h>

#include "tests/support/encirclement.hpp"

namespace sightline {
namespace {

using test::Encirclement;

constexpr double thrust = 1.458;

EvasiveManeuvers ways() { return {0.5092, 1.0}; }  // the drag of a multirotor [1/s]

Arena arena_of(const Encirclement& e) {
  const Vec2<double> d = {std::cos(e.heading), std::sin(e.heading)};
  const Vec2<double> v = rotate(d, e.v);
  return {.p = {0, 0, e.height},
          .v = v,
          .g = {Vec2<double>{thrust * d.x, thrust * d.y}, {thrust * d.y, -thrust * d.x}},
          .disc = thrust,
          .floor = e.floor,
          .ceiling = 1e6,
          .world = 1e6};
}

std::vector<Chaser> chasers_of(const Encirclement& e) {
  std::vector<Chaser> chasers;
  for (const test::Pursuer& p : e.pursuers) chasers.push_back({.p = p.p, .speed = p.speed, .hard = e.d_hard});
  return chasers;
}

TEST(EvasiveManeuvers, WhatAPlanLeavesIsWhatItsFlightLeaves) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Encirclement e = test::any_encirclement(seed);
    e.duration = 5.9;
    const Arena arena = arena_of(e);
    const int index = static_cast<int>(seed * 37 % 100);  // begins at once
    const double angle = 2 * std::numbers::pi * (index % 20) / 20, climb = -1.0 + 0.5 * (index / 20 % 5);
    const Vec2<double> along =
        rotate<double>({std::cos(e.heading), std::sin(e.heading)}, {std::cos(angle), std::sin(angle)});
    const double left = ways().left(arena, chasers_of(e), {.along = along, .climb = climb});
    EXPECT_NEAR(left, test::fly_plan(e, index).nearest - e.d_hard, 0.03) << "encirclement " << seed;
  }
}

TEST(EvasiveManeuvers, TheBestLeavesNoLessThanAnyOfThePlansThatAreTried) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Encirclement e = test::any_encirclement(seed);
    const Arena arena = arena_of(e);
    const std::vector<Chaser> chasers = chasers_of(e);
    const EvasiveManeuver best = ways().best(arena, chasers, {}, std::numeric_limits<double>::infinity());
    EXPECT_EQ(best.left, ways().left(arena, chasers, best));
    for (std::size_t i = 0; i < EvasiveManeuvers::headings; ++i) {
      for (const double climb : {-1.0, 0.0, 1.0}) {
        const EvasiveManeuver plan{.along = EvasiveManeuvers::heading(i), .climb = climb};
        const double left = ways().left(arena, chasers, plan);
        if (left >= 0) {
          EXPECT_GE(best.left, left);
        }
      }
    }
  }
}

TEST(EvasiveManeuvers, ThePlanThatIsFlownIsWorthNoLessAfterwards) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Encirclement e = test::any_encirclement(seed);
    Arena arena = arena_of(e);
    std::vector<Chaser> chasers = chasers_of(e);
    EvasiveManeuver plan = ways().best(arena, chasers, {}, std::numeric_limits<double>::infinity());
    if (plan.left < 0) continue;
    plan.taken = true;
    EXPECT_GE(ways().best(arena, chasers, plan, std::numeric_limits<double>::infinity()).left,
              plan.left - 1e-12);
  }
}

TEST(EvasiveManeuvers, TakesTheGreatestThrustThatTheInputsGiveInADirection) {
  Arena arena{.g = {Vec2<double>{1.0, 0.0}, {0.0, 2.0}}, .disc = 0.9};
  const Vec2<double> diagonal = EvasiveManeuvers::thrust(arena, {0.6, 0.8});
  EXPECT_NEAR(diagonal.x, 1.0, 1e-12);
  EXPECT_NEAR(diagonal.y, 0.8 / 0.6, 1e-12);
  EXPECT_NEAR(EvasiveManeuvers::thrust(arena, {0.0, -1.0}).y, -2.0, 1e-12);
  arena.g = {};
  EXPECT_NEAR(EvasiveManeuvers::thrust(arena, {0.0, -1.0}).y, -0.9, 1e-12);
}

}  // namespace
}  // namespace sightline
