#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "sightline/base.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

double distance(const Mat<3, 3>& a, const Mat<3, 3>& b) {
  double most = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) most = std::max(most, std::abs(a(i, j) - b(i, j)));
  return most;
}

TEST(Rotation, TurnsAreThoseOfEigenForAnglesOfEverySize) {
  Random random(1);
  for (int k = 0; k < 2000; ++k) {
    const Vec3<double> w = std::pow(10.0, uniform(random, -12, 1)) * random_point(random, 1);
    const double angle = norm(w);
    const Eigen::Matrix3d e =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(w.x, w.y, w.z) / angle).toRotationMatrix();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(turn(w)(i, j), e(i, j), 1e-14);
  }
  EXPECT_EQ(turn({}), identity<3>());
}

TEST(Rotation, TurnsAboutTheAxesAreTurnsByVectors) {
  for (const double a : {-3.0, -0.2, 0.0, 1e-9, 0.7, 2.9}) {
    EXPECT_LE(distance(turn_x(a), turn({a, 0, 0})), 1e-15);
    EXPECT_LE(distance(turn_y(a), turn({0, a, 0})), 1e-15);
    EXPECT_LE(distance(turn_z(a), turn({0, 0, a})), 1e-15);
  }
}

TEST(Rotation, AnglesComeBackAndWrap) {
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const double yaw = uniform(random, -3.1, 3.1), pitch = uniform(random, -1.4, 1.4),
                 roll = uniform(random, -3.1, 3.1);
    EXPECT_NEAR(yaw_of(turn_z(yaw) * turn_y(pitch) * turn_x(roll)), yaw, 1e-14);
    EXPECT_NEAR(wrap(yaw + 4 * std::numbers::pi), yaw, 1e-14);
  }
}

TEST(Rotation, TheGradientOfTheYawIsThatOfSmallTurns) {
  Random random(3);
  constexpr double h = 1e-6;
  for (int k = 0; k < 200; ++k) {
    const Mat<3, 3> R =
        turn_z(uniform(random, -3, 3)) * turn_y(uniform(random, -1, 1)) * turn_x(uniform(random, -1, 1));
    const auto slope = [&](const Vec3<double>& axis) {
      return wrap(yaw_of(R * turn(h * axis)) - yaw_of(R * turn(-h * axis))) / (2 * h);
    };
    const Vec3<double> g = yaw_gradient(R);
    EXPECT_NEAR(g.x, slope({1, 0, 0}), 1e-8);
    EXPECT_NEAR(g.y, slope({0, 1, 0}), 1e-8);
    EXPECT_NEAR(g.z, slope({0, 0, 1}), 1e-8);
  }
}

TEST(Rotation, WhatDriftedFromARotationIsBroughtBack) {
  Random random(4);
  for (int k = 0; k < 200; ++k) {
    const Mat<3, 3> R = turn(random_point(random, 3));
    Mat<3, 3> off = R;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) off(i, j) += uniform(random, -1e-5, 1e-5);
    const Mat<3, 3> back = orthonormal(off);
    EXPECT_LE(distance(transposed(back) * back, identity<3>()), 1e-8);
    EXPECT_LE(distance(back, R), 3e-5);
    EXPECT_LE(distance(orthonormal(R), R), 1e-15);
  }
}

}  // namespace
}  // namespace sightline
