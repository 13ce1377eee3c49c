#include "bridges/dds/links/motion_samples.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sightline/estimator.hpp"

namespace sightline::dds {
namespace {

constexpr Nanoseconds each = 10'000'000;

/// On a circle of 2 m at 1 rad/s in a frame that is turned and moved, at t [s].
SeenMotion circling(double t, double turned, const Vec3<double>& from = {}) {
  const double a = t + turned;
  Motion motion;
  motion.p = from + Vec3<double>{2 * std::cos(a), 2 * std::sin(a), 1};
  motion.q = upright({-std::sin(a), std::cos(a)});
  motion.v = {-2 * std::sin(a), 2 * std::cos(a), 0.1};
  motion.r = 1.0;
  return {motion, std::llround(1e9 * t) + 7};
}

TEST(MotionSamples, OfNoFrameButTheRobotsOwn) {
  MotionSamples one, other;
  EXPECT_FALSE(one.take(circling(5.0, 0.0), 7));
  (void)other.take(circling(5.0, 2.5, {9, 9, 9}), 7);
  const auto a = one.take(circling(5.01, 0.0), 7), b = other.take(circling(5.01, 2.5, {9, 9, 9}), 7);
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->t, 5.0, 1e-9);
  EXPECT_NEAR(a->dt, 0.01, 1e-9);
  EXPECT_NEAR(a->v_V.x, 2.0, 1e-6);
  EXPECT_NEAR(a->v_V.z, 0.1, 1e-12);
  EXPECT_NEAR(a->yaw_rate, 1.0, 1e-6);
  EXPECT_LT(norm(a->v_V - b->v_V) + std::abs(a->yaw_rate - b->yaw_rate), 1e-9);
  EXPECT_TRUE(is_usable(*a));
}

TEST(MotionSamples, OneSampleEndsWhereTheNextBegins) {
  MotionSamples samples;
  double end = -1.0;
  for (int k = 0; k < 50; ++k) {
    const auto sample = samples.take(circling(0.01 * k + 0.002 * (k % 3), 0.0), 7);
    if (!sample) continue;
    if (end >= 0) {
      EXPECT_NEAR(sample->t, end, 1e-9);
    }
    end = sample->t + sample->dt;
  }
  EXPECT_NEAR(end, 0.49 + 0.002 * (49 % 3), 1e-9);
}

TEST(MotionSamples, WhatIsRepeatedOrOlderSaysNothingAndAGapLeavesAShortSample) {
  MotionSamples samples;
  (void)samples.take(circling(1.0, 0.0), 7);
  EXPECT_FALSE(samples.take(circling(1.0, 0.0), 7));
  EXPECT_FALSE(samples.take(circling(0.9, 0.0), 7));
  EXPECT_TRUE(samples.take(circling(1.01, 0.0), 7));
  const auto after = samples.take(circling(2.0, 0.0), 7);
  ASSERT_TRUE(after);
  EXPECT_NEAR(after->t, 1.99, 1e-9);
  EXPECT_NEAR(after->dt, 0.01, 1e-9);
  EXPECT_NEAR(after->v_V.x, 2.0, 1e-6);
}

TEST(MotionSamples, ACorrectionOfTheHeadingIsNoTurn) {
  MotionSamples samples;
  (void)samples.take(circling(1.0, 0.0), 7);
  const auto jumped = samples.take(circling(1.01, 0.5), 7);
  ASSERT_TRUE(jumped);
  EXPECT_EQ(jumped->yaw_rate, 1.0);
  EXPECT_NEAR(jumped->v_V.x, 2.0, 1e-6);
}

TEST(MotionSamples, RollAndPitchAreThoseAtTheBeginning) {
  MotionSamples samples;
  const auto leaning_by = [](double roll, double pitch, int k) {
    const Mat<3, 3> R = turn_z(0.7) * tilt(roll, pitch);
    SeenMotion seen{{}, each * k};
    seen.motion.q =
        quaternion({{R(0, 0), R(1, 0), R(2, 0)}, {R(0, 1), R(1, 1), R(2, 1)}, {R(0, 2), R(1, 2), R(2, 2)}});
    return seen;
  };
  (void)samples.take(leaning_by(0.1, -0.2, 1), 0);
  const auto sample = samples.take(leaning_by(0.0, 0.0, 2), 0);
  ASSERT_TRUE(sample);
  EXPECT_NEAR(sample->roll, 0.1, 1e-9);
  EXPECT_NEAR(sample->pitch, -0.2, 1e-9);
}

}  // namespace
}  // namespace sightline::dds
