#include "bridges/dds/topics/conversion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace sightline::dds {
namespace {

constexpr double pi = std::numbers::pi;

void expect_near(const Vec3<double>& a, const Vec3<double>& b, double within = 1e-12) {
  EXPECT_NEAR(a.x, b.x, within);
  EXPECT_NEAR(a.y, b.y, within);
  EXPECT_NEAR(a.z, b.z, within);
}

/// A turn by an angle about an axis of length 1.
Quaternion about(const Vec3<double>& axis, double angle) {
  const double s = std::sin(angle / 2);
  return {std::cos(angle / 2), s * axis.x, s * axis.y, s * axis.z};
}

TEST(Conversion, NorthEastDownIsEastNorthUpTurnedOver) {
  expect_near(turned_over(Vec3<double>{1, 2, 3}), {2, 1, -3});  // p = (y, x, -z)
  expect_near(turned_over(turned_over(Vec3<double>{1, 2, 3})), {1, 2, 3});
  expect_near(body_turned_over({1, 2, 3}), {1, -2, -3});
  EXPECT_NEAR(turned_over_yaw(0.0), pi / 2, 1e-15);  // north
  EXPECT_NEAR(turned_over_yaw(pi / 2), 0.0, 1e-15);  // east
  EXPECT_NEAR(turned_over_yaw(-pi / 2), pi, 1e-12);  // west, and never -pi
  EXPECT_NEAR(turned_over_yaw(pi), -pi / 2, 1e-12);
}

// A body's attitude says where its axes point: the same place, whichever frames say it.
TEST(Conversion, AnAttitudeTurnsTheAxesOfTheBodyToTheSamePlaces) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    const Quaternion q = normalised({normal(random), normal(random), normal(random), normal(random)});
    if (q == no_attitude) continue;
    const Rotation ned = rotation(q), enu = rotation(turned_over(q));
    const Vec3<double> a_FRD = {normal(random), normal(random), normal(random)};
    expect_near(enu.to_G(body_turned_over(a_FRD)), turned_over(ned.to_G(a_FRD)));
    const Quaternion back = turned_over(turned_over(q));
    EXPECT_NEAR(std::abs(back.w * q.w + back.x * q.x + back.y * q.y + back.z * q.z), 1.0, 1e-12);
  }
}

TEST(Conversion, TheHeadingOfALevelAttitudeIsItsYawTurnedOver) {
  for (double yaw = -3.1; yaw < 3.2; yaw += 0.1) {
    const Vec2<double> d = heading(rotation(turned_over(about({0, 0, 1}, yaw))));
    const double psi = turned_over_yaw(yaw);
    EXPECT_NEAR(d.x, std::cos(psi), 1e-12);
    EXPECT_NEAR(d.y, std::sin(psi), 1e-12);
  }
}

TEST(Conversion, ALocalFrameIsTurnedAndMovedAndBack) {
  const LinkOrigin origin = {{1, 2, 3}, pi / 2};
  const Motion local = {{1, 0, 1}, about({0, 0, 1}, 0.0), {0, 2, 1}, 0.3};
  const Motion in = in_G(origin, local);
  expect_near(in.p, {1, 3, 4});
  expect_near(in.v, {-2, 0, 1});
  EXPECT_NEAR(heading(rotation(in.q)).y, 1.0, 1e-12);
  EXPECT_EQ(in.r, 0.3);
  const Motion back = in_local(origin, in);
  expect_near(back.p, local.p);
  expect_near(back.v, local.v);
  EXPECT_NEAR(heading(rotation(back.q)).x, 1.0, 1e-12);
}

TEST(Conversion, ADegreeIsAsLongAsOnTheSphereOfPx4) {
  const GeoPoint origin = {60.0, 10.0, 100.0};
  expect_near(east_north_up({60.0, 10.0 + 1e-3, 101.5}, origin), {6371000 * 0.5 * 1e-3 * pi / 180, 0, 1.5},
              1e-9);
  expect_near(east_north_up({60.0 + 1e-3, 10.0, 100.0}, origin), {0, 6371000 * 1e-3 * pi / 180, 0}, 1e-9);
}

TEST(Conversion, AQuaternionThatIsNoneIsNoAttitude) {
  const double nan = std::nan("");
  EXPECT_EQ(normalised({nan, 0, 0, 0}), no_attitude);
  EXPECT_EQ(normalised({0, 0, 0, 0}), no_attitude);
  EXPECT_EQ(normalised({1e200, 1e200, 0, 0}), no_attitude);
  EXPECT_EQ(normalised({1.001, 0, 0, 0}), Quaternion{});
}

TEST(Conversion, TimesAreTheSameNanoseconds) {
  EXPECT_EQ(of_microseconds(1'700'000'000'123'456), 1'700'000'000'123'456'000);
  EXPECT_EQ(of_ros(1'700'000'000, 5), 1'700'000'000'000'000'005);
  for (const Nanoseconds t : {Nanoseconds{0}, Nanoseconds{-1}, Nanoseconds{1'700'000'000'000'000'005}}) {
    const RosTime r = to_ros(t);
    EXPECT_LT(r.nanosec, 1'000'000'000u);
    EXPECT_EQ(of_ros(r.sec, r.nanosec), t);
  }
}

}  // namespace
}  // namespace sightline::dds
