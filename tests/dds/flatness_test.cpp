#include "bridges/dds/links/flatness.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline::dds {
namespace {

// Along a curve with all derivatives: the thrust points along the acceleration, the heading is as
// asked, and the attitude changes by the rates.
TEST(Flatness, TheAttitudeCarriesTheAccelerationAndItsRatesAreThoseOfItsChange) {
  const auto a = [](double t) { return Vec3<double>{3 * std::sin(2 * t), 2 * std::cos(t), std::sin(3 * t)}; };
  const auto j = [](double t) {
    return Vec3<double>{6 * std::cos(2 * t), -2 * std::sin(t), 3 * std::cos(3 * t)};
  };
  const auto at = [&](double t) {
    const double yaw = 0.7 * t * t;
    return flat_attitude(a(t), j(t), {std::cos(yaw), std::sin(yaw)}, 1.4 * t);
  };
  constexpr double h = 1e-5;
  for (double t = -2.0; t < 2.0; t += 0.05) {
    const FlatAttitude now = at(t);
    const Rotation R = rotation(now.q), before = rotation(at(t - h).q), after = rotation(at(t + h).q);
    const Vec3<double> up = a(t) + Vec3<double>{0, 0, gravity};
    EXPECT_LT(norm(R.z - (1 / norm(up)) * up), 1e-9) << t;
    EXPECT_NEAR(heading(R).x, std::cos(0.7 * t * t), 1e-9) << t;
    EXPECT_NEAR(heading(R).y, std::sin(0.7 * t * t), 1e-9) << t;
    const Vec3<double> x = R.to_B((0.5 / h) * (after.x - before.x)),
                       y = R.to_B((0.5 / h) * (after.y - before.y));
    EXPECT_NEAR(x.y, now.w.z, 1e-6) << t;
    EXPECT_NEAR(x.z, -now.w.y, 1e-6) << t;
    EXPECT_NEAR(y.z, now.w.x, 1e-6) << t;
  }
}

TEST(Flatness, WhatFallsIsUpright) {
  const FlatAttitude falling = flat_attitude({1, 0, -gravity}, {1, 1, 1}, {0, 1}, 0.3);
  EXPECT_NEAR(rotation(falling.q).z.z, 1.0, 1e-12);
  EXPECT_EQ(falling.w.z, 0.3);
}

}  // namespace
}  // namespace sightline::dds
