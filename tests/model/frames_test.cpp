#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sightline/model.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"
#include "tests/support/strict.hpp"

namespace sightline {
namespace {

using Transform = Eigen::Matrix4d;

/// T(p), (41).
Transform translation(double x, double y, double z) {
  Transform T = Transform::Identity();
  T.topRightCorner<3, 1>() << x, y, z;
  return T;
}

/// T_y(beta), (42).
Transform about_y(double beta) {
  Transform T = Transform::Identity();
  const double c = std::cos(beta), s = std::sin(beta);
  T.topLeftCorner<3, 3>() << c, 0, -s, 0, 1, 0, s, 0, c;
  return T;
}

/// T_z(d), (43).
Transform about_z(Vec2<double> d) {
  Transform T = Transform::Identity();
  T.topLeftCorner<3, 3>() << d.x, d.y, 0, -d.y, d.x, 0, 0, 0, 1;
  return T;
}

/// From the frame of a mount: T_SV = T_y(beta) of an offset ahead, (45), and its generalisation.
Transform sensor_from_frame(const SensorMount& mount) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  const Transform back = translation(-mount.offset.x, -mount.offset.y, -mount.offset.z);
  if (mount.yaw == 0 && mount.roll == 0) return about_y(mount.pitch) * back;
  Transform T = Transform::Identity();
  T.topLeftCorner<3, 3>() =
      (AngleAxisd(-mount.roll, Vector3d::UnitX()) * AngleAxisd(-mount.pitch, Vector3d::UnitY()) *
       AngleAxisd(-mount.yaw, Vector3d::UnitZ()))
          .toRotationMatrix();
  return T * back;
}

/// T_SG = T_SV T_VG, (44)-(46).
Transform sensor_from_global(const SensorMount& mount, const Pose<double>& robot) {
  const Transform T_VG = about_z(robot.d) * translation(-robot.p.x, -robot.p.y, -robot.p.z);
  return sensor_from_frame(mount) * T_VG;
}

/// The same pose with another velocity and lean.
Sight<double> random_sight_at(Random& random, const Pose<double>& pose) {
  Sight<double> seen = random_sight(random, 3);
  static_cast<Pose<double>&>(seen) = pose;
  return seen;
}

TEST(SensorMount, TheClosedFormIsTheProductOfTheTransforms) {
  Random random(1);
  for (int k = 0; k < 20'000; ++k) {
    const SensorMount mount = random_mount(random);
    const Pose<double> robot = random_pose(random, 3);
    const Vec3<double> point = random_point(random, 3), p_S = mount(robot, point);
    const Eigen::Vector4d expected =
        sensor_from_global(mount, robot) * Eigen::Vector4d(point.x, point.y, point.z, 1.0);
    EXPECT_NEAR(p_S.x, expected[0], 8e-15);
    EXPECT_NEAR(p_S.y, expected[1], 8e-15);
    EXPECT_NEAR(p_S.z, expected[2], 8e-15);
  }
}

/// A cone that holds the farthest point holds all that are `sigmas` deviations beside the target,
/// but near the axis.
TEST(SensorMount, TheFarthestPointIsAsFarOffTheAxisAsAnyOfTheDoubt) {
  Random random(21);
  for (int trial = 0; trial < 1000; ++trial) {
    SensorMount mount = random_mount(random);
    mount.sigmas = uniform(random, 0.1, 3.0);
    const double uncertainty = uniform(random, 0.001, 0.3), rho = mount.sigmas * uncertainty;
    const Vec3<double> p{uniform(random, 0.5, 4.0), uniform(random, -2, 2), uniform(random, -2, 2)};
    const Vec3<double> far = mount.farthest(uncertainty, p);
    const double aside = std::hypot(p.y, p.z), out = std::hypot(far.y, far.z);
    EXPECT_EQ(far.x, p.x);
    EXPECT_NEAR(far.y * p.z, far.z * p.y, 1e-12) << "in the same direction";
    EXPECT_LT(out, aside + rho);
    EXPECT_GT(out, aside + rho * std::min(1.0, aside / rho) * 0.7);
    if (aside > 3 * rho) {
      EXPECT_GT(out, aside + 0.94 * rho);
    }
  }
  const SensorMount uncertain{.sigmas = 2.0};
  for (const double on_the_axis :
       {uncertain.farthest(0.1, Vec3<double>{1, 0, 0}).y, uncertain.farthest(0.0, Vec3<double>{1, 0, 0}).y})
    EXPECT_EQ(on_the_axis, 0.0);
  EXPECT_EQ(uncertain.farthest(0.0, Vec3<double>{1, 0.3, 0.2}).y, 0.3) << "who is sure sees what is there";
}

TEST(SensorMount, TheAxisInTheVehicleIsTurnedByTheYawAndThenDown) {
  Random random(4);
  for (int k = 0; k < 5000; ++k) {
    const SensorMount mount = random_mount(random);
    const double far = uniform(random, 0.1, 5);
    const Pose<double> robot{{}, {1.0, 0.0}};  // V is G
    const double ahead = far * std::cos(mount.pitch);
    const Vec3<double> on_axis =
        mount.offset +
        Vec3<double>{ahead * std::cos(mount.yaw), ahead * std::sin(mount.yaw), -far * std::sin(mount.pitch)};
    const Vec3<double> p_S = mount(robot, on_axis);
    EXPECT_NEAR(p_S.x, far, 3e-15 * (1 + far));
    EXPECT_NEAR(std::hypot(p_S.y, p_S.z), 0.0, 3e-15 * (1 + far));
  }
}

TEST(SensorMount, PointsOfSAndOfGAreThereAndBackAgain) {
  Random random(5);
  for (int k = 0; k < 5000; ++k) {
    const SensorMount mount = random_mount(random);
    const Vec3<double> p_S = random_point(random, 3);
    EXPECT_LE(norm(mount(Pose<double>{{}, {1.0, 0.0}}, mount.point_in_F(p_S)) - p_S), 4e-15);
    const double distance = uniform(random, 1.0, 5.0), depth = mount.depth_at(distance);
    EXPECT_NEAR(norm(mount.point_in_F({depth, 0, 0})), distance, 2e-15 * distance);
  }
  EXPECT_EQ((SensorMount{.pitch = 0.0, .offset = {0.0, 0.3, 0.0}}.depth_at(0.1)), 0.0) << "all are farther";
}

// A camera that is turned to the left on a robot that is turned to the right looks where one ahead
// did.
TEST(SensorMount, AYawOfTheSensorAndAHeadingOfTheRobotAreOneTurn) {
  Random random(6);
  for (int k = 0; k < 2000; ++k) {
    SensorMount mount = random_mount(random);
    mount.yaw = 0.0;
    const double psi = uniform(random, -3, 3), by = uniform(random, -3, 3);
    const Pose<double> robot{random_point(random, 3), {std::cos(psi), std::sin(psi)}},
        other{robot.p, {std::cos(psi - by), std::sin(psi - by)}};
    SensorMount turned = mount;
    turned.yaw = by;
    turned.offset.x = mount.offset.x * std::cos(by) - mount.offset.y * std::sin(by);
    turned.offset.y = mount.offset.x * std::sin(by) + mount.offset.y * std::cos(by);
    const Vec3<double> point = random_point(random, 3);
    EXPECT_LE(norm(mount(robot, point) - turned(other, point)), 5e-15);
  }
}

TEST(SensorMount, RollTurnsThePictureWithItsLeftSideUp) {
  const SensorMount rolled = {.pitch = 0.0, .offset = 0.0, .roll = 0.5};
  const Vec3<double> level = rolled(Pose<double>{{}, {1, 0}}, Vec3<double>{2, 1, 0});
  EXPECT_GT(level.y, 0);
  EXPECT_LT(level.z, 0) << "what is level on the left is below the raised axis to the left";
}

TEST(SensorMount, ARobotThatDoesNotLeanIsSeenFromAlikeInBothFrames) {
  Random random(20);
  for (int k = 0; k < 20'000; ++k) {
    const SensorMount level = random_mount(random);
    SensorMount body = level;
    body.frame = MountFrame::body;
    const Sight<double> upright = {random_pose(random, 3), random_point(random, 1)};
    const Vec3<double> point = random_point(random, 3);
    const Vec3<double> expected = level(static_cast<const Pose<double>&>(upright), point);
    for (const Vec3<double>& p_S : {body(upright, point), level(random_sight_at(random, upright), point)})
      EXPECT_EQ((std::array{p_S.x, p_S.y, p_S.z}), (std::array{expected.x, expected.y, expected.z}));
    EXPECT_EQ(view_angle(body, upright, point), view_angle(level, upright, point));
  }
}

TEST(SensorMount, TheBodyFrameIsThatOfTheAnglesYawPitchRoll) {
  Random random(21);
  for (int k = 0; k < 20'000; ++k) {
    const double psi = uniform(random, -3.1, 3.1), theta = uniform(random, -1.2, 1.2),
                 phi = uniform(random, -1.2, 1.2);
    const Eigen::Matrix3d tilt = (Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(phi, Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();  // V from B
    const Eigen::Vector3d thrust = tilt.col(2);
    const Sight<double> robot = {{random_point(random, 3), {std::cos(psi), std::sin(psi)}},
                                 {},
                                 {thrust.x() / thrust.z(), thrust.y() / thrust.z()}};
    SensorMount mount = random_mount(random);
    mount.frame = MountFrame::body;
    const Vec3<double> point = random_point(random, 3), p_S = mount(robot, point);
    // A sensor that is fixed to the body, by transforms: T_SB T_BV T_VG.
    Transform T_BV = Transform::Identity();
    T_BV.topLeftCorner<3, 3>() = tilt.transpose();
    const Transform T_VG = about_z(robot.d) * translation(-robot.p.x, -robot.p.y, -robot.p.z);
    const Eigen::Vector4d expected =
        sensor_from_frame(mount) * T_BV * T_VG * Eigen::Vector4d(point.x, point.y, point.z, 1.0);
    EXPECT_LE(norm(p_S - Vec3<double>{expected[0], expected[1], expected[2]}), 2e-14);
    EXPECT_NEAR(view_angle(mount, robot, point),
                std::acos(std::clamp(expected[0] / expected.head<3>().norm(), -1.0, 1.0)), 1e-7);
  }
}

TEST(SensorMount, WhoLeansForwardLooksDownAndWhoLeansLeftSeesTheTargetGoRight) {
  const SensorMount camera = {.pitch = 0.0, .offset = 0.0, .frame = MountFrame::body};
  const auto seen = [&](Vec2<double> lean) {
    return camera(Sight<double>{{{}, {1, 0}}, {}, lean}, Vec3<double>{2, 0, 0});
  };
  EXPECT_GT(seen({0.3, 0}).z, 0.1) << "the target ahead is above the axis";
  EXPECT_EQ(seen({0.3, 0}).y, 0.0);
  const Vec3<double> below = camera(Sight<double>{{{}, {1, 0}}, {}, {0, 0.3}}, Vec3<double>{2, 0, -1});
  EXPECT_GT(below.y, 0.1) << "to the left, the side to which the top leans, rises: what is below goes there";
}

TEST(SensorMount, EveryScalarSeesTheSamePoint) {
  Random random(6);
  for (int k = 0; k < 1000; ++k) {
    const SensorMount mount = random_mount(random);
    const Pose<double> r = random_pose(random, 3);
    const Vec3<double> p = random_point(random, 3), expected = mount(r, p);
    const auto strict =
        mount(Pose<Strict>{{r.p.x, r.p.y, r.p.z}, {r.d.x, r.d.y}}, Vec3<Strict>{p.x, p.y, p.z});
    const auto lanes =
        mount(Pose<NativeLane>{{r.p.x, r.p.y, r.p.z}, {r.d.x, r.d.y}}, Vec3<NativeLane>{p.x, p.y, p.z});
    EXPECT_EQ(strict.x.value(), expected.x);
    EXPECT_EQ(strict.y.value(), expected.y);
    EXPECT_EQ(strict.z.value(), expected.z);
    EXPECT_EQ(lanes.x[0], expected.x);
    EXPECT_EQ(lanes.y[0], expected.y);
    EXPECT_EQ(lanes.z[0], expected.z);
  }
}

TEST(Frames, RotationKeepsLengthsAndTheTransposeUndoesIt) {
  Random random(7);
  for (int k = 0; k < 5000; ++k) {
    const Vec2<double> d = random_pose(random, 1).d, v{uniform(random, -3, 3), uniform(random, -3, 3)};
    const Vec2<double> v_G = rotate(d, v), back = rotate({d.x, -d.y}, v_G);
    EXPECT_LE(relative_error(dot(v_G, v_G), dot(v, v)), 1e-14);
    EXPECT_NEAR(back.x, v.x, 4e-15);
    EXPECT_NEAR(back.y, v.y, 4e-15);
    // Headings turn as angles add.
    const double angle = std::atan2(d.y, d.x) + std::atan2(v.y, v.x);
    EXPECT_NEAR(std::sin(angle), v_G.y / std::hypot(v_G.x, v_G.y), 1e-13);
  }
}

TEST(ViewAngle, IsTheAngleBetweenTheAxisAndThePoint) {
  Random random(8);
  for (int k = 0; k < 5000; ++k) {
    const SensorMount mount = random_mount(random);
    const Pose<double> robot = random_pose(random, 3);
    const Vec3<double> point = random_point(random, 3), p_S = mount(robot, point);
    const double angle = view_angle(mount, robot, point);
    EXPECT_GE(angle, 0.0);
    EXPECT_LE(angle, std::numbers::pi);
    EXPECT_NEAR(std::cos(angle), p_S.x / norm(p_S), 1e-14);  // (71)
  }
}

TEST(ViewAngle, KeepsItsDigitsNearTheAxis) {
  Random random(9);
  for (int k = 0; k < 1000; ++k) {
    const SensorMount mount{0.0, 0.0};
    const double angle = std::exp(uniform(random, std::log(1e-12), std::log(0.1)));
    const Pose<double> robot{{}, {1.0, 0.0}};
    EXPECT_LE(relative_error(view_angle(mount, robot, {2.0, 0.0, -2.0 * std::tan(angle)}), angle, 0.0),
              1e-14);
  }
  EXPECT_EQ(view_angle({}, {{-0.17, 0.0, 0.0}, {1.0, 0.0}}, {}), 0.0);  // at the sensor itself
}

TEST(Sight, WhatIsWrittenIsReadInTheOrderPositionHeadingVelocityLean) {
  std::array<double, sight_size> row;
  for (std::size_t i = 0; i < row.size(); ++i) row[i] = 1.0 + static_cast<double>(i);
  const auto s = sight_from<double>(row);
  EXPECT_EQ((std::array{s.p.x, s.p.y, s.p.z, s.d.x, s.d.y, s.v.x, s.v.y, s.v.z, s.lean.x, s.lean.y}), row);
  std::array<double, sight_size> again{};
  write_sight(s, again);
  EXPECT_EQ(again, row);
}

}  // namespace
}  // namespace sightline
