#include "bridges/dds/links/inertial_samples.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "sightline/world.hpp"
#include "tests/support/refusal.hpp"

namespace sightline::dds {
namespace {

constexpr Nanoseconds imu_ms = 1'000'000, imu_start = 1'000'000 * imu_ms;

MotionSample lasting(Nanoseconds length) {
  MotionSample motion;
  motion.dt = 1e-9 * static_cast<double>(length);
  return motion;
}

const Vec3<double> some_rate = {0.3, -0.2, 1.0}, some_force = {0.5, 0.1, 9.7};

/// Measurements of the same rate and force, each 5 ms in (from, to].
void put_equal(InertialSamples& samples, Nanoseconds from, Nanoseconds to, Nanoseconds each = 5 * imu_ms) {
  for (Nanoseconds t = from + each; t <= to; t += each) samples.put({t, some_rate, some_force}, t);
}

bool are_equal_to_some(const MotionSample& motion) {
  return norm(motion.gyro - some_rate) < 1e-12 && norm(motion.force - some_force) < 1e-12;
}

// Whatever the periods of both are: the sum of what the filter integrates is that of what was
// measured.
TEST(InertialSamples, TheMeansIntegrateToAllThatWasMeasured) {
  RandomStream random(3, StreamId::draw, 0);
  for (int run = 0; run < 200; ++run) {
    InertialSamples samples;
    std::vector<InertialSample> all = {{imu_start, {}, {}}};
    const auto put_until = [&](Nanoseconds t) {
      while (all.back().stamp < t) {
        const Nanoseconds passed = 1 * imu_ms + std::llround(random.uniform() * 7e6);
        all.push_back({all.back().stamp + passed, random.normals(), 9.0 * random.normals()});
        samples.put(all.back(), t);
      }
    };
    // Over [from, to], of the measurements as they are.
    const auto integral = [&](Nanoseconds from, Nanoseconds to) {
      Vec3<double> sum{};
      for (std::size_t i = 1; i < all.size(); ++i) {
        const Nanoseconds a = std::max(all[i - 1].stamp, from), b = std::min(all[i].stamp, to);
        if (b > a) sum = sum + 1e-9 * static_cast<double>(b - a) * all[i].gyro;
      }
      return sum;
    };
    put_until(imu_start + 30 * imu_ms);
    Nanoseconds end = imu_start + 20 * imu_ms;
    Vec3<double> sum{};
    const Nanoseconds first = end;
    for (int k = 0; k < 40; ++k) {
      const Nanoseconds length = 2 * imu_ms + std::llround(random.uniform() * 40e6);
      end += length;
      put_until(end + std::llround(random.uniform() * 15e6));
      MotionSample motion = lasting(length);
      ASSERT_TRUE(samples.fill(end, motion));
      EXPECT_LT(norm(motion.dt * motion.gyro - integral(end - length, end)), 1e-12);
      sum = sum + motion.dt * motion.gyro;
    }
    EXPECT_LT(norm(sum - integral(first, end)), 1e-11);
  }
}

TEST(InertialSamples, WhatIsLostOrStillUnderWayIsReplacedByTheMeanOfTheRest) {
  InertialSamples samples;
  put_equal(samples, imu_start, imu_start + 20 * imu_ms);
  put_equal(samples, imu_start + 25 * imu_ms, imu_start + 45 * imu_ms,
            10 * imu_ms);  // each second one is lost
  for (int k = 1; k <= 4; ++k) {
    MotionSample motion = lasting(10 * imu_ms);
    EXPECT_TRUE(samples.fill(imu_start + 10 * k * imu_ms, motion)) << k;
    EXPECT_TRUE(are_equal_to_some(motion)) << k;
  }
  MotionSample late = lasting(10 * imu_ms);  // 5 of 10 ms are measured
  EXPECT_TRUE(samples.fill(imu_start + 50 * imu_ms, late));
  EXPECT_TRUE(are_equal_to_some(late));
}

// Poses may come just before the measurements that end with them, each time.
TEST(InertialSamples, TheNewestHoldsForAsLongAsItIsSaidTo) {
  for (const Nanoseconds held : {Nanoseconds{0}, 10 * imu_ms}) {
    InertialSamples samples(held);
    for (int k = 0; k < 5; ++k) {
      samples.put({imu_start + (10 * k + 1) * imu_ms, k * some_rate, some_force}, 0);
      MotionSample motion = lasting(10 * imu_ms);
      const bool filled = samples.fill(imu_start + (10 * k + 10) * imu_ms, motion);
      EXPECT_EQ(filled, held > 0) << k;
      if (filled) {
        EXPECT_NEAR(norm(motion.gyro - k * some_rate), 0.0, 1e-12) << k;
      }
    }
    MotionSample gap = lasting(10 * imu_ms);
    EXPECT_FALSE(samples.fill(imu_start + 70 * imu_ms, gap)) << "9 ms after it ceased to hold";
  }
}

TEST(InertialSamples, AMotionOfWhichLessThanHalfIsMeasuredIsNone) {
  InertialSamples samples;
  MotionSample motion = lasting(10 * imu_ms);
  motion.force = {1, 2, 3};
  EXPECT_FALSE(samples.fill(imu_start, motion));
  EXPECT_EQ(motion.force.y, 2.0) << "it is left as it is";
  put_equal(samples, imu_start, imu_start + 14 * imu_ms, 2 * imu_ms);
  motion = lasting(10 * imu_ms);
  EXPECT_TRUE(samples.fill(imu_start + 10 * imu_ms, motion));
  EXPECT_FALSE(samples.fill(imu_start + 20 * imu_ms, motion)) << "4 of 10 ms";
  EXPECT_FALSE(samples.fill(imu_start + 30 * imu_ms, motion));
  // One that comes after a long silence stands for no more than 20 ms.
  samples.put({imu_start + 300 * imu_ms, some_rate, some_force}, 0);
  motion = lasting(50 * imu_ms);
  EXPECT_FALSE(samples.fill(imu_start + 300 * imu_ms, motion));
  put_equal(samples, imu_start + 300 * imu_ms, imu_start + 310 * imu_ms);
  motion = lasting(10 * imu_ms);
  EXPECT_TRUE(samples.fill(imu_start + 310 * imu_ms, motion));
  EXPECT_TRUE(are_equal_to_some(motion));
}

TEST(InertialSamples, WhatIsRepeatedOrOutOfOrderOrNotFiniteCountsForNothing) {
  InertialSamples samples;
  for (int k = 1; k <= 4; ++k) {
    const Nanoseconds t = imu_start + 5 * k * imu_ms;
    samples.put({t, some_rate, some_force}, t);
    samples.put({t, {99, 99, 99}, some_force}, t);
    samples.put({t - 6 * imu_ms, {99, 99, 99}, some_force}, t);
    samples.put({t, {not_a_number, 0, 0}, some_force}, t);
    samples.put({t, some_rate, {0, infinite, 0}}, t);
  }
  EXPECT_EQ(samples.not_finite(), 8);
  for (const int k : {1, 2}) {
    MotionSample motion = lasting(10 * imu_ms);
    EXPECT_TRUE(samples.fill(imu_start + 10 * k * imu_ms, motion));
    EXPECT_TRUE(are_equal_to_some(motion)) << motion.gyro.x;
  }
}

// The odometry of the same clock jumps with it.
TEST(InertialSamples, AJumpOfTheClockCostsNoMoreThanAMotion) {
  for (const double jump : {-2.0, 2.0, -0.5, 0.5}) {
    InertialSamples samples;
    Nanoseconds t = imu_start;
    put_equal(samples, t - 20 * imu_ms,
              t + 30 * imu_ms);  // 30 ms are there when the odometry has its last stamp
    MotionSample motion = lasting(10 * imu_ms);
    EXPECT_TRUE(samples.fill(t, motion));
    t += std::llround(1e9 * jump);
    int failed = 0;
    for (int k = 0; k < 20; ++k, t += 10 * imu_ms) {
      put_equal(samples, t, t + 10 * imu_ms);
      motion = lasting(10 * imu_ms);
      const bool filled = samples.fill(t + 10 * imu_ms, motion);
      failed += filled ? 0 : 1;
      if (filled) {
        EXPECT_TRUE(are_equal_to_some(motion)) << jump;
      }
    }
    EXPECT_LE(failed, 1) << jump;
  }
}

TEST(InertialSamples, WhatCameBeforeTheTaskIsForgottenHoweverMuchItIs) {
  InertialSamples samples;
  for (int k = 0; k < 5000; ++k) samples.put({imu_start + k * imu_ms, {99, 99, 99}, {}}, k * imu_ms);
  samples.forget();
  const Nanoseconds t = imu_start + 5000 * imu_ms;
  put_equal(samples, t, t + 30 * imu_ms);
  MotionSample motion = lasting(10 * imu_ms);
  EXPECT_TRUE(samples.fill(t + 20 * imu_ms, motion));
  EXPECT_TRUE(are_equal_to_some(motion));
}

}  // namespace
}  // namespace sightline::dds
