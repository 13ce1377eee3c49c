#include <gtest/gtest.h>

#include <vector>

#include "sightline/estimator.hpp"
#include "tests/support/filter_derivatives.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

TEST(Measurement, OneWithANumberThatIsNotFiniteOrAVarianceThatIsNotPositiveIsOfNoUse) {
  Random random(1);
  const Measurement good = test::random_sighting(random);
  ASSERT_TRUE(good.is_usable());
  std::vector<Measurement> bad(9, good);
  bad[0].stamp = not_a_number;
  bad[1].z.y = not_a_number;
  bad[2].R(0, 1) = bad[2].R(1, 0) = not_a_number;
  bad[3].R = {};
  bad[4].yaw = not_a_number;
  bad[5].yaw_variance = 0.0;
  bad[6].p_other.z = infinite;
  bad[7].P_other(2, 2) = -1.0;
  bad[8].P_other(3, 3) = not_a_number;
  for (std::size_t i = 0; i < bad.size(); ++i) EXPECT_FALSE(bad[i].is_usable()) << i;
}

TEST(Measurement, WhatItDoesNotMeasureDoesNotCount) {
  Random random(2);
  Measurement z = test::random_sighting(random);
  z.has_yaw = false;
  z.yaw = not_a_number;
  EXPECT_TRUE(z.is_usable());
  EXPECT_FALSE(z.measures_heading());
  z.of = Measures::position;
  z.p_other.x = not_a_number;
  EXPECT_TRUE(z.is_usable());
  z.of = Measures::heading;
  EXPECT_FALSE(z.is_usable()) << "its yaw is what it measures";
  z.yaw = 0.3;
  z.R = {};
  EXPECT_TRUE(z.is_usable());
  EXPECT_FALSE(z.measures_position());
}

TEST(Measurement, TheHeadingThatItMeansIsTheOthersLessTheYawBetweenThem) {
  Measurement z{.has_yaw = true, .yaw = 0.5, .yaw_variance = 0.01, .psi_other = 0.7};
  z.P_other(3, 3) = 0.02;
  EXPECT_DOUBLE_EQ(z.heading(), 0.2);
  EXPECT_DOUBLE_EQ(z.heading_variance(), 0.03);
  z.of = Measures::heading;
  EXPECT_DOUBLE_EQ(z.heading(), 0.5);
  EXPECT_DOUBLE_EQ(z.heading_variance(), 0.01);
}

TEST(Measurement, AMotionOfNoTimeOrWithoutANumberIsOfNoUse) {
  const MotionSample good{.t = 1.0};
  EXPECT_TRUE(is_usable(good));
  MotionSample bad = good;
  bad.dt = 0.0;
  EXPECT_FALSE(is_usable(bad));
  bad = good;
  bad.v_V.x = not_a_number;
  EXPECT_FALSE(is_usable(bad));
  bad = good;
  bad.gyro.z = not_a_number;
  EXPECT_FALSE(is_usable(bad));
}

}  // namespace
}  // namespace sightline
