#include <gtest/gtest.h>

#include "tests/support/encirclement.hpp"

namespace sightline {
namespace {

using test::Encirclement;
using test::Fate;
using test::highest;
using test::lowest;
using test::State;
using test::VehicleInput;
using test::Wish;

/// So many pursuers, evenly round the robot at its height.
Encirclement ring(int count, double far, double speed, Wish wish) {
  Encirclement e{.wish = wish};
  for (int i = 0; i < count; ++i) {
    const double angle = 0.2 + 2 * std::numbers::pi * i / count;
    e.pursuers.push_back({{far * std::cos(angle), far * std::sin(angle), e.height}, speed});
  }
  return e;
}

TEST(BarrierAgainstSeveral, KeepsDistanceAndFloorInARingThatCloses) {
  const Barrier filter = test::barrier_of_encirclements();
  for (const Wish wish : {Wish::stay, Wish::meet}) {
    for (const Encirclement& e :
         {ring(3, 4.0, 0.5, wish), ring(4, 4.0, 1.0, wish), ring(6, 2.5, 1.0, wish)}) {
      const Fate fate = test::fly_filtered(filter, e);
      EXPECT_GE(fate.nearest, e.d_hard) << e.pursuers.size();
      EXPECT_GE(fate.lowest, e.floor - 1e-9);
      EXPECT_TRUE(std::isinf(fate.reported));
    }
  }
}

TEST(BarrierAgainstSeveral, KeepsItFromUncooperativeOnesThatTurnAtWillWhileAPlanIsSafeFromAll) {
  const Barrier filter = test::barrier_of_encirclements();
  int flown = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const Encirclement e = test::any_adversaries(seed);
    if (!test::is_safe_from_all(filter, e)) continue;
    ++flown;
    const Fate fate = test::fly_filtered(filter, e);
    EXPECT_GE(fate.nearest, e.d_hard) << "adversaries " << seed;
    EXPECT_GE(fate.lowest, e.floor - 1e-9);
    EXPECT_TRUE(std::isinf(fate.reported));
  }
  EXPECT_GE(flown, 6);
}

TEST(BarrierAgainstSeveral, TellsAtOnceWhereThereIsNoWayOut) {
  const Barrier filter = test::barrier_of_encirclements();
  Encirclement e = ring(6, 0.75, 1.5, Wish::stay);
  e.pursuers.push_back({{0.0, 0.0, 1.8}, 1.5});
  e.height = 0.5;
  ASSERT_FALSE(test::has_maneuver(e));
  const Fate fate = test::fly_filtered(filter, e);
  EXPECT_LT(fate.nearest, e.d_hard);
  EXPECT_LT(fate.reported, fate.broken);
  EXPECT_EQ(fate.reported, 0.0);
  EXPECT_GE(fate.lowest, e.floor - 1e-9);
  EXPECT_GE(fate.nearest, test::fly_wish(e).nearest - 0.01);
}

TEST(BarrierAgainstSeveral, AtTheCeilingItSinksOutOfARing) {
  // A ring above the middle of the room, around a robot that has nowhere left to climb.
  const Barrier filter(Multirotor{}, lowest, highest, 0.01, {.floor = 0.3, .ceiling = 6.0, .world = 100.0});
  const State x = {0, 0, 6.0, 1, 0, 0, 0};
  std::array<Neighbour, 6> pursuers;
  for (std::size_t i = 0; i < pursuers.size(); ++i) {
    const double angle = std::numbers::pi * static_cast<double>(i) / 3;
    pursuers[i] = {.p = {1.6 * std::cos(angle), 1.6 * std::sin(angle), 6.0}, .d_hard = 0.6, .speed_max = 0.2};
  }
  VehicleInput u = {0, 0, 0, 0};
  const BarrierResult result = filter.filter(x, pursuers, lowest, highest, u);
  EXPECT_FALSE(result.surrounded);
  EXPECT_FALSE(result.conflict);
}

TEST(BarrierAgainstSeveral, APlanThatClimbsLagsByWhatTheRateAllowsAtMost) {
  const Barrier filter = test::barrier_of_encirclements();
  const State x = {0, 0, 1, 1, 0, 0, 0};
  for (const double far : {0.9, 1.0}) {
    std::array<Neighbour, 6> pursuers;
    for (std::size_t i = 0; i < pursuers.size(); ++i) {
      const double angle = std::numbers::pi * static_cast<double>(i) / 3;
      const Vec3<double> p = {far * std::cos(angle), far * std::sin(angle), 1};
      pursuers[i] = {.p = p, .d_hard = 0.6, .speed_max = 0.4};
    }
    VehicleInput u = {0, 0, -1, 0};
    const BarrierResult result = filter.filter(x, pursuers, lowest, highest, u);
    EXPECT_FALSE(result.surrounded);
    const double climb = filter.options().authority, rate = filter.options().rate;
    EXPECT_GE(u[2], climb - rate * std::max(result.reserve, 0.0) - 1e-6) << far;
  }
}

TEST(BarrierAgainstSeveral, WhoIsFarAwayOrOnTheSameSideChangesNothing) {
  const Barrier filter = test::barrier_of_encirclements();
  const State x = {0, 0, 1, 1, 0, 0.4, 0};
  const Neighbour threat{.p = {1.75, 0, 1}, .d_hard = 0.6, .speed_max = 1.0};
  for (const Vec3<double>& beside : {Vec3<double>{-10.5, 0, 1}, {0, 11, 1}, {6, 0.5, 1}, {5, -0.5, 2}}) {
    const std::array<Neighbour, 2> both = {threat, Neighbour{.p = beside, .d_hard = 0.6, .speed_max = 1.0}};
    VehicleInput alone = {1, 0, 0, 0.1}, u = alone;
    const BarrierResult one = filter.filter(x, std::span(&threat, 1), lowest, highest, alone),
                        two = filter.filter(x, both, lowest, highest, u);
    EXPECT_TRUE(one.active);
    EXPECT_EQ(u, alone);
    EXPECT_EQ(two.reserve, one.reserve);
    EXPECT_FALSE(two.surrounded);
  }
}

TEST(BarrierAgainstSeveral, StaysOnTheWayThatItTook) {
  const Barrier filter = test::barrier_of_encirclements();
  int taken = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Encirclement e = test::any_encirclement(seed);
    EvasiveManeuver maneuver;
    int turns = 0;
    test::fly_among(e, [&](const State& x, const auto& pursuers, const auto& v, double) {
      std::vector<Neighbour> others;
      for (std::size_t i = 0; i < pursuers.size(); ++i) {
        others.push_back({.p = pursuers[i].p, .v = v[i], .d_hard = e.d_hard, .speed_max = pursuers[i].speed});
      }
      const EvasiveManeuver before = maneuver;
      VehicleInput u = test::wish(e, x, pursuers);
      filter.filter(x, others, lowest, highest, u, maneuver);
      taken += maneuver.taken;
      turns += before.taken && maneuver.taken && dot(before.along, maneuver.along) < 0.5;
      return u;
    });
    EXPECT_LE(turns, 6) << "encirclement " << seed;
  }
  EXPECT_GT(taken, 25);
}

}  // namespace
}  // namespace sightline
