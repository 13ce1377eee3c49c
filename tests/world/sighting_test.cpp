#include "sightline/world/sighting.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

Quaternion as_quaternion(const Mat<3, 3>& R) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = R(i, j);
  const Eigen::Quaterniond e(m);
  return {e.w(), e.x(), e.y(), e.z()};
}

TEST(Sighting, ItsYawIsTheHeadingOfTheTargetLessThatOfTheObserver) {
  Random random(1);
  for (int k = 0; k < 300; ++k) {
    const SensorMount mount = random_mount(random, k % 2 == 0 ? MountFrame::body : MountFrame::level);
    const double psi = uniform(random, -3, 3), other = uniform(random, -3, 3);
    const Vec2<double> lean = {uniform(random, -0.4, 0.4), uniform(random, -0.4, 0.4)};
    const Mat<3, 3> held =
        turn_z(psi) * (mount.frame == MountFrame::body ? tilt(lean.x, lean.y) : identity<3>());
    const Mat<3, 3> R_GT = turn_z(other) * tilt(uniform(random, -0.3, 0.3), uniform(random, -0.3, 0.3));
    Detection d{.target = BodyId{3}, .stamp = 2.5, .p = random_point(random, 2)};
    d.q = as_quaternion(transposed(held * mount.attitude()) * R_GT);
    for (std::size_t i = 0; i < 6; ++i) d.covariance[Detection::place(i, i)] = 0.01;
    const Measurement z = sighting_of(d, mount, lean);
    EXPECT_NEAR(wrap(z.yaw - (other - psi)), 0.0, 1e-12);
    EXPECT_EQ(norm(z.z - d.p), 0.0);
    EXPECT_EQ(z.stamp, 2.5);
    EXPECT_EQ(z.source, 3);
    EXPECT_TRUE(z.is_usable());
  }
}

TEST(Sighting, TheCovarianceOfTheYawIsThatOfSmallTurns) {
  Random random(2);
  constexpr double by = 1e-6;
  for (int k = 0; k < 100; ++k) {
    const SensorMount mount = random_mount(random, MountFrame::body);
    const Vec2<double> lean = {uniform(random, -0.4, 0.4), uniform(random, -0.4, 0.4)};
    Detection d{.p = random_point(random, 2)};
    const Mat<3, 3> R_ST = turn(random_point(random, 0.4));
    // A covariance B B^T of all six errors.
    Mat<6, 6> B;
    for (auto& row : B.row)
      for (double& v : row) v = uniform(random, -0.1, 0.1);
    const Mat<6, 6> P = B * transposed(B);
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = i; j < 6; ++j) d.covariance[Detection::place(i, j)] = P.row[i][j];
    const auto yaw = [&](const Vec3<double>& turned) {
      Detection off = d;
      off.q = as_quaternion(turn(turned) * R_ST);
      return sighting_of(off, mount, lean).yaw;
    };
    Mat<1, 6> J;
    J(0, 3) = wrap(yaw({by, 0, 0}) - yaw({-by, 0, 0})) / (2 * by);
    J(0, 4) = wrap(yaw({0, by, 0}) - yaw({0, -by, 0})) / (2 * by);
    J(0, 5) = wrap(yaw({0, 0, by}) - yaw({0, 0, -by})) / (2 * by);
    d.q = as_quaternion(R_ST);
    const Measurement z = sighting_of(d, mount, lean);
    EXPECT_NEAR(z.yaw_variance, (J * P * transposed(J))(0, 0), 1e-7);
    const Mat<6, 1> cross = P * transposed(J);
    EXPECT_NEAR(z.R_yaw.x, cross(0, 0), 1e-7);
    EXPECT_NEAR(z.R_yaw.y, cross(1, 0), 1e-7);
    EXPECT_NEAR(z.R_yaw.z, cross(2, 0), 1e-7);
    EXPECT_NEAR(z.R(1, 2), P(1, 2), 1e-15);
  }
}

TEST(Sighting, APositionAloneHasNoYaw) {
  Detection d{.p = {2, 0, 0}};
  for (std::size_t i = 0; i < 3; ++i) d.covariance[Detection::place(i, i)] = 0.01;
  const Measurement z = sighting_of(d, {}, {});
  EXPECT_FALSE(z.measures_heading());
  EXPECT_TRUE(z.is_usable());
}

}  // namespace
}  // namespace sightline
