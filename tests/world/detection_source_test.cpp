#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "sightline/sensors.hpp"

namespace sightline {
namespace {

CameraOptions one_camera(double misalignment) {
  CameraOptions options;
  options.cameras = {{.observer = BodyId{0},
                      .mount = {.pitch = 0.0, .offset = 0.0},
                      .camera = {.misalignment = misalignment}}};
  return options;
}

TEST(DetectionSource, ACameraIsTurnedByItsMisalignmentAboutAnAxisOfTheSeed) {
  CameraOptions options = one_camera(0.035);
  const Rotation turned = drawn_misalignments(options).at(0);
  const double trace = turned.x.x + turned.y.y + turned.z.z;
  EXPECT_NEAR(std::acos(0.5 * (trace - 1)), 0.035, 1e-9);
  EXPECT_EQ(drawn_misalignments(options).at(0).x.y, turned.x.y) << "the same seed";
  options.seed = 2;
  EXPECT_NE(drawn_misalignments(options).at(0).x.y, turned.x.y);
  const Rotation none = drawn_misalignments(one_camera(0.0)).at(0);
  EXPECT_EQ(none.x.x, 1.0);
  const RigidPose S = camera_pose(options.cameras[0], turned, {});
  EXPECT_EQ(S.R.x.y, turned.x.y);
}

TEST(DetectionSource, WhatPassesIsSmearedWhileThePictureIsExposed) {
  const CameraOptions options = one_camera(0.0);
  const double f = options.cameras[0].camera.focal();
  std::array<ExposedBody, 2> bodies{};
  bodies[1].before.p = {2.0, 0.02, 0.0};
  bodies[1].now.p = {2.0, -0.02, 0.0};  // 4 m/s to the right
  const Exposure exposure{0, 1.0, 0.01, bodies};
  const Vec2<double> smear = smear_of(options, exposure, {}, BodyId{1});
  EXPECT_NEAR(smear.x, f * 4.0 / 2.0 * options.cameras[0].camera.exposure, 1e-9);
  EXPECT_EQ(smear.y, 0.0);
  bodies[0].before.R = turn_by({0, 0, 0.01});  // and the camera turns to the right
  EXPECT_LT(smear_of(options, exposure, {}, BodyId{1}).x, smear.x);
  EXPECT_EQ(smear_of(options, {0, 0.0, 0.0, bodies}, {}, BodyId{1}).x, 0.0) << "the first picture";
  bodies[1].now.p.x = -2.0;
  EXPECT_EQ(smear_of(options, exposure, {}, BodyId{1}).x, 0.0) << "behind the camera";
}

}  // namespace
}  // namespace sightline
