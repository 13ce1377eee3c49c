#include "sightline/estimate/heading_filter.hpp"

#include <gtest/gtest.h>

#include "tests/support/filter_derivatives.hpp"

namespace sightline {
namespace {

constexpr SensorMount leaning_mount{.pitch = 0.4, .offset = 0.17, .frame = MountFrame::body};
constexpr SensorMount level_mount{.pitch = 0.4, .offset = 0.17, .frame = MountFrame::level};
constexpr SensorMount leaning_aside{
    .pitch = 0.4, .offset = {0.1, -0.2, 0.05}, .frame = MountFrame::body, .yaw = 1.5, .roll = -0.7};
constexpr SensorMount level_aside{
    .pitch = 0.4, .offset = {0.1, -0.2, 0.05}, .frame = MountFrame::level, .yaw = 1.5, .roll = -0.7};

TEST(HeadingFilter, TheCovarianceGoesOnAsTheStateDoes) {
  test::expect_propagation(HeadingFilter({}, leaning_mount), 1e-8);
}

TEST(HeadingFilter, AnInnovationChangesWithTheStateAsHSays) {
  test::expect_sensitivity(HeadingFilter({}, leaning_mount), 1e-6);
  test::expect_sensitivity(HeadingFilter({}, level_mount), 1e-6);
  test::expect_sensitivity(HeadingFilter({}, leaning_aside), 1e-6);
  test::expect_sensitivity(HeadingFilter({}, level_aside), 1e-6);
}

TEST(HeadingFilter, ADoubtfulHeadingWeakensASightingAcrossTheLineOfSightAlone) {
  const HeadingFilter filter({}, level_mount);
  HeadingFilter::State s;
  s.P = identity<HeadingFilter::n>(1e-4);
  Measurement z{.z = {2, 0, 0}, .R = identity<3>(1e-4), .p_other = {2.17, 0, 0}};
  const Innovation<4, HeadingFilter::n> sure = filter.innovation(s, z, {});
  s.P(3, 3) = 0.25;
  const Innovation<4, HeadingFilter::n> uncertain = filter.innovation(s, z, {});
  // Seen from ahead a turn shortens the way by (1 - cos) of it: along the line of sight, 0.5 psi^2
  // of the distance.
  EXPECT_NEAR(uncertain.R(0, 0) - sure.R(0, 0), 0.5 * 0.25 * 0.25 * 2.17 * 2.17, 1e-6);
  EXPECT_NEAR(uncertain.R(1, 1), sure.R(1, 1), 1e-12);
  EXPECT_NEAR(uncertain.R(2, 2), sure.R(2, 2), 1e-12);
}

TEST(HeadingFilter, TwoHalvesOfASampleAreTheWholeButForTheTurn) {
  Random random(3);
  const HeadingFilter filter({}, leaning_mount);
  for (int k = 0; k < 100; ++k) {
    const auto s = test::random_state(filter, random);
    MotionSample u = test::random_motion(random);
    u.yaw_rate = s.rate_bias;
    auto whole = s, halves = s;
    filter.advance(whole, u, 0.01);
    filter.advance(halves, u, 0.005);
    filter.advance(halves, u, 0.005);
    EXPECT_LE(test::greatest(test::difference(whole, halves)), 1e-4);
    EXPECT_LE(test::greatest(whole.P - halves.P), 1e-4);
  }
}

}  // namespace
}  // namespace sightline
