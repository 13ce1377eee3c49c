#include "sightline/estimate/attitude_filter.hpp"

#include <gtest/gtest.h>

#include "tests/support/filter_derivatives.hpp"

namespace sightline {
namespace {

constexpr SensorMount on_body{.pitch = 0.4, .offset = 0.17, .frame = MountFrame::body};
constexpr SensorMount on_gimbal{.pitch = 0.4, .offset = 0.17, .frame = MountFrame::level};
constexpr SensorMount aside_on_body{
    .pitch = 0.4, .offset = {0.1, -0.2, 0.05}, .frame = MountFrame::body, .yaw = 1.5, .roll = -0.7};
constexpr SensorMount aside_on_gimbal{
    .pitch = 0.4, .offset = {0.1, -0.2, 0.05}, .frame = MountFrame::level, .yaw = 1.5, .roll = -0.7};

TEST(AttitudeFilter, TheCovarianceGoesOnAsTheStateDoes) {
  // The gyroscope's bias is taken along axes of the step's beginning, so to first order in the turn
  // of a step.
  test::expect_propagation(AttitudeFilter({}, on_body), 2e-5);
}

TEST(AttitudeFilter, AnInnovationChangesWithTheStateAsHSays) {
  test::expect_sensitivity(AttitudeFilter({}, on_body), 1e-6);
  test::expect_sensitivity(AttitudeFilter({}, on_gimbal), 1e-6);
  test::expect_sensitivity(AttitudeFilter({}, aside_on_body), 1e-6);
  test::expect_sensitivity(AttitudeFilter({}, aside_on_gimbal), 1e-6);
}

TEST(AttitudeFilter, FallsFreelyWithoutForceAndHoversUnderThatOfItsWeight) {
  const AttitudeFilter filter({}, on_body);
  const MotionSample falling{}, hovering{.force = {0, 0, gravity}};
  AttitudeFilter::State s;
  for (int k = 0; k < 100; ++k) filter.advance(s, falling, 0.01);
  EXPECT_NEAR(s.v.z, -gravity, 1e-9);
  EXPECT_NEAR(s.p.z, -0.5 * gravity, 1e-9);
  s = {};
  for (int k = 0; k < 100; ++k) filter.advance(s, hovering, 0.01);
  EXPECT_NEAR(norm(s.p) + norm(s.v), 0.0, 1e-12);
}

TEST(AttitudeFilter, TheAttitudeStaysARotationForHours) {
  const AttitudeFilter filter({}, on_body);
  AttitudeFilter::State s;
  s.P = {};
  const MotionSample spinning{.gyro = {0.7, -0.4, 1.1}, .force = {0, 0, gravity}};
  for (int k = 0; k < 400'000; ++k) filter.advance(s, spinning, 0.01);
  EXPECT_LE(test::greatest(transposed(s.R) * s.R - identity<3>()), 1e-14);
}

TEST(AttitudeFilter, TheToldVelocityBindsTheVelocityAndTheHeadingThatItTurnsWith) {
  const AttitudeFilter filter({}, on_body);
  AttitudeFilter::State s;
  s.v = {0.95, 0.3, 0};
  for (int i = 0; i < AttitudeFilter::n; ++i) s.P(i, i) = i < 6 ? 1e-6 : 0.0;
  s.P(8, 8) = 0.04;  // heading
  const MotionSample ahead{.v_V = {1, 0, 0}};
  for (int k = 0; k < 40; ++k) filter.end(s, ahead);
  EXPECT_NEAR(yaw_of(s.R), 0.3, 0.05) << "it flies to the left in G and ahead in V: it looks to the left";
  EXPECT_LT(s.P(8, 8), 0.01);
}

}  // namespace
}  // namespace sightline
