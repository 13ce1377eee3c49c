#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "sightline/world.hpp"

namespace sightline {
namespace {

double distance(const Vec3<double>& a, const Vec3<double>& b) { return norm(a - b); }

std::mt19937_64 random_numbers(11);
double within(double a) { return std::uniform_real_distribution<double>(-a, a)(random_numbers); }
Vec3<double> vector_within(double a) { return {within(a), within(a), within(a)}; }

RigidBody tumbling() {
  const Vec3<double> axis = vector_within(0.57);
  const Quaternion attitude = {sqrt(1 - dot(axis, axis)), axis.x, axis.y, axis.z};
  return {.mass = 2.0,
          .inertia = {0.02, 0.03, 0.04},
          .v = vector_within(3),
          .q = attitude,
          .w = vector_within(4)};
}

TEST(RigidBody, ItsRotationKeepsLengthsAndAnglesAndTurnsThereAndBack) {
  for (int k = 0; k < 1000; ++k) {
    RigidBody body = tumbling();
    for (int step = 0; step < 50; ++step) body.step({}, vector_within(0.1), 0.01);
    const Rotation R = rotation(body.q);
    const Vec3<double> a = vector_within(1), b = vector_within(1);
    EXPECT_NEAR(dot(R.to_G(a), R.to_G(b)), dot(a, b), 1e-14);
    EXPECT_LT(distance(R.to_B(R.to_G(a)), a), 1e-14);
    EXPECT_LT(distance(cross(R.x, R.y), R.z), 1e-14);
  }
}

TEST(RigidBody, TheAttitudeOfAHeadingAndALeanHasThem) {
  for (int k = 0; k < 1000; ++k) {
    const double psi = within(3.1);
    const Vec2<double> d = {std::cos(psi), std::sin(psi)}, xi = {within(2), within(2)};
    const Quaternion q = leaning(d, xi);
    EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1.0, 1e-14);
    const Rotation R = rotation(q);
    EXPECT_NEAR(heading(R).x, d.x, 1e-13);
    EXPECT_NEAR(heading(R).y, d.y, 1e-13);
    EXPECT_NEAR(lean(R).x, xi.x, 1e-13);
    EXPECT_NEAR(lean(R).y, xi.y, 1e-13);
    EXPECT_NEAR(R.z.z, 1 / std::sqrt(1 + xi.x * xi.x + xi.y * xi.y), 1e-13);
  }
}

TEST(RigidBody, ALeanIsFiniteHoweverItTumbles) {
  for (const double turn : {1.5, 1.6, 3.1, 4.0}) {
    const Vec2<double> xi = lean(rotation({std::cos(turn / 2), std::sin(turn / 2), 0, 0}));
    EXPECT_TRUE(std::isfinite(xi.x) && std::isfinite(xi.y)) << turn;
  }
}

TEST(RigidBody, WithoutForcesMomentumStaysBitForBitAndEnergyAndAngularMomentumToTheOrderOfTheStep) {
  const auto drift = [](RigidBody body, double h) {
    const double E = body.energy();
    const Vec3<double> L = body.angular_momentum(), P = body.momentum();
    for (int k = 0; k < std::lround(2.0 / h); ++k) body.step({}, {}, h);
    EXPECT_EQ(distance(body.momentum(), P), 0.0);
    return std::max(std::abs(body.energy() / E - 1), distance(body.angular_momentum(), L) / norm(L));
  };
  for (int k = 0; k < 20; ++k) {
    const RigidBody body = tumbling();
    const double coarse = drift(body, 1e-3), fine = drift(body, 1e-4);
    EXPECT_LT(coarse, 0.02);
    EXPECT_LT(fine, 0.2 * coarse + 1e-12);
  }
}

TEST(RigidBody, ASpinAboutAPrincipalAxisIsExact) {
  RigidBody body{.inertia = {0.02, 0.03, 0.04}, .w = {0, 0, 1.7}};
  for (int k = 0; k < 3000; ++k) body.step({}, {}, 1e-3);
  const Rotation R = rotation(body.q);
  EXPECT_NEAR(R.x.x, std::cos(1.7 * 3), 1e-12);
  EXPECT_NEAR(R.x.y, std::sin(1.7 * 3), 1e-12);
  EXPECT_EQ(body.w.z, 1.7);
}

TEST(RigidBody, FallsWithTheVelocityOfTheEndOfEachStepAsMuJoCosEulerDoes) {
  RigidBody body{.mass = 3.0};
  const double h = 1e-3;
  const int n = 2000;
  for (int k = 0; k < n; ++k) body.step({0, 0, -3.0 * gravity}, {}, h);
  EXPECT_NEAR(body.v.z, -gravity * n * h, 1e-11);
  EXPECT_NEAR(body.p.z, -0.5 * gravity * h * h * n * (n + 1), 1e-10);
}

TEST(RigidBody, TorqueDoesTheWorkThatTheRotationGains) {
  RigidBody body{.inertia = {0.02, 0.03, 0.04}};
  double work = 0.0;
  const double h = 1e-4;
  for (int k = 0; k < 20000; ++k) {
    const Vec3<double> torque = {0.01 * std::sin(1e-3 * k), 0.02, -0.01};
    const Vec3<double> before = body.w;
    body.step({}, torque, h);
    work += 0.5 * h * dot(torque, before + body.w);
  }
  EXPECT_NEAR(body.energy(), work, 0.01 * work);
}

}  // namespace
}  // namespace sightline
