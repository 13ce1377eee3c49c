#include <gtest/gtest.h>

#include <numbers>

#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

Bearing random_bearing(Random& random) {
  return {.alpha = uniform(random, 0.1, 1.4),
          .width = uniform(random, 0.02, 0.2),
          .tilt = uniform(random, 0.05, 0.2),
          .mount = {
              .pitch = uniform(random, -0.8, 0.8),
              .offset = {uniform(random, -0.3, 0.3), uniform(random, -0.3, 0.3), uniform(random, -0.3, 0.3)},
              .yaw = random() % 2 == 0 ? 0.0 : uniform(random, -3, 3),
              .roll = uniform(random, -3, 3)}};
}

/// l with the target `far` [m] from the sensor, phi off where it looks (> 0: to the left) and `up`
/// above it.
double at(const Bearing& bearing, double far, double phi, double up) {
  const Sight<double> observer{{-1.0 * bearing.mount.offset, {1.0, 0.0}}, {}};
  const double yaw = bearing.mount.yaw + phi;
  return bearing(observer, Sight<double>{{{far * std::cos(yaw), far * std::sin(yaw), up}, {1.0, 0.0}}, {}});
}

/// Slope over the bearing [1/rad].
double slope(const Bearing& bearing, double far, double phi, double up) {
  constexpr double step = 1e-6;
  return (at(bearing, far, phi + step, up) - at(bearing, far, phi - step, up)) / (2 * step);
}

TEST(Bearing, IsOneLessTheCosineOfTheViewAngleInTheHalfSpaceAhead) {
  Random random(1);
  for (int k = 0; k < 5000; ++k) {
    Bearing bearing = random_bearing(random);
    bearing.width = 1e-6;
    const Sight<double> a = random_sight(random, 3), b = random_sight(random, 3);
    SensorMount level = bearing.mount;
    level.pitch = level.roll = 0.0;
    if (level(a, b.p).x < 0) bearing.tilt = 0;
    EXPECT_NEAR(bearing(a, b), 1 - std::cos(view_angle(bearing.mount, a, b.p)), 1e-9);
  }
}

TEST(Bearing, IsAtMostTwoAndNeverNegative) {
  Random random(2);
  for (int k = 0; k < 20'000; ++k) {
    const double l = random_bearing(random)(random_sight(random, 3), random_sight(random, 3));
    EXPECT_GE(l, 0);
    EXPECT_LE(l, 2);
  }
}

// The only bearings at which nothing turns the robot are straight ahead and one between 189 and 192
// degrees.
TEST(Bearing, BetweenTheNoseAndTheRidgeBehindTheRobotAlwaysTurnsTowardsTheTarget) {
  Random random(3);
  for (int k = 0; k < 5000; ++k) {
    Bearing bearing = random_bearing(random);
    bearing.tilt = 0.2, bearing.width = 0.01;
    const double far = uniform(random, 0.3, 100), up = uniform(random, -1, 1);
    const double share = std::cos(bearing.mount.pitch) * far / std::hypot(far, up);
    EXPECT_GT(slope(bearing, far, uniform(random, 0.01, pi * 189 / 180), up), 0.005 * share);
    EXPECT_LT(slope(bearing, far, uniform(random, -pi * 168 / 180, -0.01), up), -0.005 * share);
  }
}

TEST(Bearing, StraightBehindTheTurnIsToTheLeftAndWithoutTiltThereIsNone) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    Bearing bearing = random_bearing(random);
    bearing.mount.pitch = 0;
    EXPECT_GT(slope(bearing, 3.0, pi, 0.0), 0.9 * std::sin(0.95 * bearing.tilt));
    bearing.tilt = 0;
    EXPECT_NEAR(slope(bearing, 3.0, pi, 0.0), 0.0, 1e-9);
  }
}

TEST(Bearing, AHalfAngleBeyondAQuarterTurnLeavesOutACone) {
  Random random(5);
  for (int k = 0; k < 1000; ++k) {
    const double alpha = uniform(random, pi / 2, pi), off = uniform(random, 0, pi),
                 roll = uniform(random, -pi, pi);
    const Bearing wide = {.alpha = alpha, .mount = {.pitch = 0.0, .offset = 0.0}};
    const Vec3<double> p = {std::cos(off), std::sin(off) * std::cos(roll), std::sin(off) * std::sin(roll)};
    const Sight<double> observer = {{{}, {1.0, 0.0}}, {}}, target = {{p, {1.0, 0.0}}, {}};
    EXPECT_NEAR(wide.violation(observer, target), off - alpha, 1e-7);
  }
}

TEST(Bearing, ASensorThatLooksStraightDownSeesWhatIsBelow) {
  const Bearing down = {.alpha = 0.3, .mount = {.pitch = pi / 2, .offset = 0.0}};
  const Sight<double> observer = {{{0, 0, 2}, {0.6, 0.8}}, {}};
  const auto seen = [&](const Vec3<double>& p) { return down.violation(observer, {{p, {1.0, 0.0}}, {}}); };
  EXPECT_NEAR(seen({0, 0, 0}), -0.3, 1e-7);
  EXPECT_NEAR(seen({0.2, 0, 0}), std::atan2(0.2, 2.0) - 0.3, 1e-12);
  EXPECT_NEAR(seen({0, 0, 3}), pi - 0.3, 1e-7);
}

TEST(Bearing, AMountOutOfItsRangeIsRefusedByName) {
  const auto refusal = [](Bearing bearing) { return refusal_of([&] { bearing.check(); }); };
  EXPECT_EQ(refusal({.mount = {.pitch = 1.6}}), "bearing.mount.pitch = 1.6, expected in [-pi/2, pi/2] rad");
  EXPECT_NE(refusal({.mount = {.offset = not_a_number}}), "");
  EXPECT_EQ(refusal({.mount = {.offset = {0.0, -5.5}}}), "bearing.mount.offset = -5.5, expected -5 to 5 m");
  EXPECT_EQ(refusal({.mount = {.yaw = 3.2}}), "bearing.mount.yaw = 3.2, expected in [-pi, pi] rad");
  EXPECT_EQ(refusal({.mount = {.roll = -3.2}}), "bearing.mount.roll = -3.2, expected in [-pi, pi] rad");
  EXPECT_EQ(refusal({.alpha = pi, .mount = {.pitch = -pi / 2}}), "");
}

}  // namespace
}  // namespace sightline
