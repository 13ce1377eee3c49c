// The guarantee of docs/safety.md at periods from 1 ms to the longest, against bodies and robots that do their worst.
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/model/hover_multirotor.hpp"
#include "sightline/model/velocity_multirotor.hpp"
#include "sightline/safety/barrier.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/chase.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::barrier_of;
using test::ChaseOutcome;

/// From 1 ms to the longest, as many of each factor of ten.
double any_period(Random& random) {
  return std::min(Barrier::longest_period, std::pow(10.0, uniform(random, -3.0, -0.3)));
}

/// Robots whose plans are exact.
Model any_robot(Random& random) {
  switch (random() % 5) {
    case 0:
      return HoverMultirotor{};
    case 1:
      return AngleMultirotor{};
    case 2:
      return LaggedMultirotor<Lags::climb>{.yaw_max = 0.3};
    case 3: {
      const double drag = uniform(random, 0.35, 0.55), b = uniform(random, 1.4, 3.0);
      return Multirotor{.b_psi = uniform(random, 0.5, 2.0), .a_f = -drag, .b_f = b, .a_s = -drag, .b_s = b};
    }
    default:
      return Multirotor{};
  }
}

int flights(int whole) { return runs(whole, 40); }

TEST(BarrierCheck, OneBodyIsKeptAwayAtEveryPeriodUpToTheLongest) {
  int flown = 0;
  for (int i = 0; i < flights(20000); ++i) {
    Random random(static_cast<std::uint64_t>(i));
    // Short periods take as many updates more.
    const double period = i % 8 == 0 ? any_period(random) : uniform(random, 0.02, Barrier::longest_period);
    const Model robot = any_robot(random);
    const Barrier barrier = barrier_of(robot, period, {.floor = 0.3, .world = 1000.0});
    const ChaseOutcome outcome =
        test::chase(robot, barrier, {.period = period}, static_cast<std::uint64_t>(i) + 1);
    if (!outcome.began) continue;
    ++flown;
    EXPECT_GE(outcome.spare, 0.0) << robot.name() << " at " << period << " s, seed " << i;
    EXPECT_GE(outcome.lowest, 0.3 - 1e-6) << robot.name() << " at " << period << " s, seed " << i;
    EXPECT_GE(outcome.reserve, -2e-3) << robot.name() << " at " << period << " s, seed " << i;
    EXPECT_EQ(outcome.conflicts, 0) << robot.name() << " at " << period << " s, seed " << i;
  }
  EXPECT_GT(flown, flights(20000) * 9 / 10);
}

TEST(BarrierCheck, SeveralBodiesAreKeptAwayAtEveryPeriodUpToTheLongest) {
  int flown = 0;
  for (int i = 0; i < flights(8000); ++i) {
    Random random(static_cast<std::uint64_t>(i));
    const double period = uniform(random, 0.02, Barrier::longest_period);
    const Model robot = i % 2 == 0 ? Model(Multirotor{}) : Model(AngleMultirotor{});
    const Barrier barrier = barrier_of(robot, period, {.floor = 0.3, .world = 1000.0});
    const ChaseOutcome outcome = test::chase(robot, barrier, {.period = period, .bodies = 2 + i % 3},
                                             static_cast<std::uint64_t>(i) + 1);
    flown += outcome.began;
    EXPECT_TRUE(!outcome.began || outcome.spare >= 0.0)
        << outcome.spare << " m at " << period << " s, seed " << i;
  }
  EXPECT_GT(flown, flights(8000) / 2);
}

TEST(BarrierCheck, TwoRobotsKeepApartAtEveryPeriodAlsoWhereOneIsStronger) {
  for (int i = 0; i < flights(20000); ++i) {
    Random random(static_cast<std::uint64_t>(i));
    const double period = i % 8 == 0 ? any_period(random) : uniform(random, 0.02, Barrier::longest_period);
    const double b = i % 2 == 0 ? 1.458 : uniform(random, 1.0, 3.0);
    const Model one = Multirotor{},
                other = i % 3 == 0 ? Model(AngleMultirotor{}) : Model(Multirotor{.b_f = b, .b_s = b});
    const BarrierOptions walls{.floor = 0.3, .world = 1000.0};
    const Barrier first = barrier_of(one, period, walls), second = barrier_of(other, period, walls);
    const ChaseOutcome outcome =
        test::meet({&one, &other}, {&first, &second}, period, static_cast<std::uint64_t>(i) + 1);
    EXPECT_GE(outcome.spare, 0.0) << "at " << period << " s, seed " << i;
    EXPECT_EQ(outcome.conflicts, 0) << "at " << period << " s, seed " << i;
  }
}

TEST(BarrierCheck, FloorCeilingAndABoundOfTheWorldAreKeptBetweenSamplesAtEveryPeriod) {
  for (int i = 0; i < flights(4000); ++i) {
    Random random(static_cast<std::uint64_t>(i));
    const double period = uniform(random, 0.01, Barrier::longest_period);
    const Model robot = any_robot(random);
    const Barrier barrier = barrier_of(robot, period, {.floor = 0.3, .ceiling = 3.0, .world = 6.0});
    test::Chased flown(robot, barrier, period, 0.0, uniform(random, 0.5, 2.5), random);
    for (int k = 0; k < static_cast<int>(12.0 / period); ++k) {
      // At a bound, up and down; never into a corner of two.
      const Vec3<double> p = flown.sight().p;
      flown.command({i % 2 == 0 ? 50.0 : -50.0, 0.0, k / 20 % 2 == 0 ? 9.0 : -9.0}, {}, random);
      if (std::abs(p.y) > 2.0) break;
      for (int part = 0; part < flown.parts(); ++part) {
        flown.fly(period / flown.parts());
        const Vec3<double> now = flown.sight().p;
        ASSERT_GE(now.z, 0.3 - 1e-6) << robot.name() << " at " << period << " s, seed " << i;
        ASSERT_LE(now.z, 3.0 + 1e-6) << robot.name() << " at " << period << " s, seed " << i;
        ASSERT_LE(std::abs(now.x), 6.0 + 1e-6) << robot.name() << " at " << period << " s, seed " << i;
      }
    }
  }
}

TEST(BarrierCheck, ALongerPeriodIsRefusedWithTheLongest) {
  EXPECT_EQ(refusal_of([] { Barrier(Multirotor{}, test::lowest, test::highest, 0.6, {.rate = 1.0}); }),
            "barrier: period = 0.6, expected in (0, 0.5] s, the longest for which the hard distance is "
            "guaranteed");
}

}  // namespace
}  // namespace sightline
