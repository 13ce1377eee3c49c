#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/sensors.hpp"
#include "sightline/world.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

using std::numbers::pi;

Camera camera_with(Distortion distortion, std::vector<double> coefficients) {
  return {.width = 640,
          .height = 480,
          .focal_length = {301.5, 298.25},
          .principal_point = {311.0, 251.5},
          .distortion = distortion,
          .coefficients = std::move(coefficients)};
}

std::vector<Camera> lenses() {
  return {
      camera_with(Distortion::none, {}),
      camera_with(Distortion::plumb_bob, {-0.28, 0.07, 0.0003, -0.0011}),
      camera_with(Distortion::plumb_bob, {0.11, -0.21, -0.002, 0.003, 0.09}),
      camera_with(Distortion::rational_polynomial, {0.45, -0.12, 0.001, -0.0004, 0.02, 0.71, -0.05, 0.03}),
      camera_with(Distortion::equidistant, {-0.013, 0.021, -0.012, 0.002}),
      camera_with(Distortion::equidistant, {0, 0, 0, 0})};
}

/// Pixel of a point by the formulas that OpenCV documents (calib3d: projectPoints, and fisheye), in
/// its axes: x right, y down, z ahead. Written without the formulas of the library.
Vec2<double> documented(const Camera& camera, const Vec3<double>& p_S) {
  const double X = -p_S.y, Y = -p_S.z, Z = p_S.x;
  std::vector<double> d = camera.coefficients;
  d.resize(8);
  double x = X / Z, y = Y / Z;
  if (camera.distortion == Distortion::equidistant) {
    const double r = std::sqrt(X * X + Y * Y), theta = std::acos(Z / std::sqrt(X * X + Y * Y + Z * Z));
    const double theta_d = theta + d[0] * std::pow(theta, 3) + d[1] * std::pow(theta, 5) +
                           d[2] * std::pow(theta, 7) + d[3] * std::pow(theta, 9);
    x = theta_d * X / r, y = theta_d * Y / r;
  } else {
    const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const double radial = (1 + d[0] * r2 + d[1] * r4 + d[4] * r6) / (1 + d[5] * r2 + d[6] * r4 + d[7] * r6);
    const double x_d = x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x);
    const double y_d = y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y;
    x = x_d, y = y_d;
  }
  return {camera.focal_length[0] * x + camera.principal_point[0],
          camera.focal_length[1] * y + camera.principal_point[1]};
}

/// A point at a random distance, at most `angle` off the axis.
Vec3<double> point_within(Random& random, double angle) {
  const double theta = uniform(random, 1e-3, angle), phi = uniform(random, -pi, pi),
               d = uniform(random, 0.3, 5.0);
  return {d * std::cos(theta), d * std::sin(theta) * std::cos(phi), d * std::sin(theta) * std::sin(phi)};
}

/// Where a lens has pixels of its own, and the decentering does not fold.
double range_of(const Camera& camera) {
  return std::min(0.97 * camera.widest(), camera.distortion == Distortion::equidistant ? pi : 1.1);
}

TEST(CameraLens, AgreesWithTheFormulasThatOpenCvDocuments) {
  Random random(7);
  for (const Camera& camera : lenses()) {
    camera.check();
    for (int k = 0; k < 2000; ++k) {
      const Vec3<double> p = point_within(random, range_of(camera));
      ASSERT_TRUE(camera.sees(p, camera.widest()));
      const Vec2<double> at = camera.project(p), is = documented(camera, p);
      const double scale = 1 + std::abs(is.x) + std::abs(is.y);
      EXPECT_NEAR(at.x + 320, is.x, 1e-9 * scale);
      EXPECT_NEAR(at.y + 240, is.y, 1e-9 * scale);
    }
  }
}

TEST(CameraLens, ItsSlopesAreDifferencesOfItsProjection) {
  Random random(8);
  constexpr double h = 1e-6;
  for (const Camera& camera : lenses()) {
    for (int k = 0; k < 500; ++k) {
      const Vec3<double> p = point_within(random, std::min(range_of(camera), pi - 0.1));
      const auto [right, down] = camera.slopes(p);
      const auto difference = [&](const Vec3<double>& way) {
        const Vec2<double> a = camera.project(p - h * way), b = camera.project(p + h * way);
        return Vec2<double>{(b.x - a.x) / (2 * h), (b.y - a.y) / (2 * h)};
      };
      const double size = 1 + norm(right) + norm(down);
      for (const auto& [way, of_right, of_down] : {std::tuple{Vec3<double>{1, 0, 0}, right.x, down.x},
                                                   std::tuple{Vec3<double>{0, 1, 0}, right.y, down.y},
                                                   std::tuple{Vec3<double>{0, 0, 1}, right.z, down.z}}) {
        const Vec2<double> is = difference(way);
        EXPECT_NEAR(of_right, is.x, 1e-6 * size);
        EXPECT_NEAR(of_down, is.y, 1e-6 * size);
      }
    }
  }
}

TEST(CameraLens, ARayIsTheDirectionThatItsPixelPictures) {
  Random random(9);
  for (const Camera& camera : lenses()) {
    for (int k = 0; k < 1000; ++k) {
      const Vec3<double> p = point_within(random, range_of(camera));
      const auto ray = camera.ray(camera.project(p));
      ASSERT_TRUE(ray) << norm(p.y, p.z) / p.x;
      EXPECT_NEAR(norm(*ray), 1.0, 1e-12);
      EXPECT_NEAR(norm(*ray - (1 / norm(p)) * p), 0.0, 1e-7);
    }
    const auto middle = camera.ray({camera.principal_point[0] - 320, camera.principal_point[1] - 240});
    ASSERT_TRUE(middle);
    EXPECT_NEAR(middle->x, 1.0, 1e-12) << "the axis is at the principal point";
  }
}

TEST(CameraLens, BeyondTheFoldOfALensThereIsNoPixel) {
  // The image of r (1 - 0.28 r^2 + 0.07 r^4) would turn back where its slope is zero.
  const Camera barrel = camera_with(Distortion::plumb_bob, {-0.5, 0.0, 0.0, 0.0});
  const double fold = std::atan(std::sqrt(1 / 1.5));
  EXPECT_NEAR(barrel.widest(), fold, 0.01);
  EXPECT_LT(barrel.widest(), fold);
  EXPECT_TRUE(barrel.sees({1.0, 0.5, 0.0}, barrel.widest()));
  EXPECT_FALSE(barrel.sees({1.0, 0.9, 0.0}, barrel.widest()));
  const double most = std::sqrt(1 / 1.5) * (1 - 0.5 / 1.5);  // farthest image, in focal lengths
  EXPECT_TRUE(barrel.ray({-9.0 + 301.5 * 0.95 * most, 11.5}));
  EXPECT_FALSE(barrel.ray({-9.0 + 301.5 * 1.05 * most, 11.5}));
  EXPECT_FALSE(barrel.sees({-1.0, 0.0, 0.0}, barrel.widest())) << "nothing behind it";
}

TEST(CameraLens, AnEquidistantLensSeesUpToPi) {
  const Camera round{.width = 800,
                     .height = 800,
                     .field_of_view = 2 * pi,
                     .distortion = Distortion::equidistant,
                     .coefficients = {0, 0, 0, 0}};
  round.check();
  EXPECT_EQ(round.widest(), pi);
  for (const double theta : {0.5, 1.66, 2.5, 3.1}) {
    const Vec3<double> p = {2 * std::cos(theta), -2 * std::sin(theta), 0.0};
    EXPECT_TRUE(round.sees(p, round.widest()));
    EXPECT_NEAR(round.project(p).x, 400 * theta / pi, 1e-9) << theta;
  }
  EXPECT_NEAR(round.pixels(0.1, round.depth({-2.0, 0.0, 0.0})), 400 / pi * 0.05, 1e-9);
}

TEST(CameraLens, RefusesCoefficientsThatItsDistortionDoesNotHave) {
  EXPECT_THAT(refusal_of([] { camera_with(Distortion::none, {0.1}).check(); }),
              HasSubstr("camera.coefficients has 1 numbers, expected none without a distortion"));
  EXPECT_THAT(refusal_of([] {
                camera_with(Distortion::plumb_bob, {0.1, 0.2}).check();
              }),
              HasSubstr("4 or 5"));
  EXPECT_THAT(refusal_of([] {
                camera_with(Distortion::equidistant, {0, 0, 0, 0, 0}).check();
              }),
              HasSubstr("4 with"));
  EXPECT_THAT(refusal_of([] {
                camera_with(Distortion::rational_polynomial, {0, 0, 0, 0, 0}).check();
              }),
              HasSubstr("8"));
  EXPECT_THAT(refusal_of([] {
                Camera{.focal_length = {300, 0}}.check();
              }),
              HasSubstr("both above 0, or neither"));
  EXPECT_THAT(refusal_of([] { Camera{.field_of_view = 3.0}.check(); }),
              HasSubstr("camera.field_of_view = 3"));
}

/// A body with its first face towards the camera, in this direction.
RigidPose tag_facing(const Vec3<double>& p) {
  const Vec3<double> back = (-1 / norm(p.x, p.y)) * Vec3<double>{p.x, p.y, 0};
  return {p, {back, {-back.y, back.x, 0}, {0, 0, 1}}};
}

TEST(CameraLens, TagPosesAreFoundThroughEachLensWithoutAGuess) {
  const Tags tags{.size = 0.2, .faces = 4, .distance = 0.132};
  for (const Camera& camera : lenses()) {
    const bool fisheye = camera.distortion == Distortion::equidistant;
    const std::vector<double> angles =
        fisheye ? std::vector{0.0, 0.6, -1.5, 1.75, 2.2} : std::vector{0.0, 0.3, -0.45};
    for (const double angle : angles) {
      RigidPose pose = tag_facing({1.1 * std::cos(angle), 1.1 * std::sin(angle), 0.2});
      pose.R = compose(pose.R, turn_by({0.05, -0.1, 0.3}));
      std::vector<FoundTag> found = {{0, {}}};
      const auto corners = tags.corners(0);
      for (std::size_t i = 0; i < 4; ++i) {
        const Vec3<double> p = pose.p + pose.R.to_G(corners[i]);
        ASSERT_TRUE(camera.sees(p, camera.widest()));
        const Vec2<double> at = documented(camera, p);
        found[0].corners[i] = {at.x - 320, at.y - 240};
      }
      const auto said = pose_of(camera, tags, found, pose.R.z);
      ASSERT_TRUE(said) << angle;
      EXPECT_NEAR(norm(said->pose.p - pose.p), 0.0, 1e-6) << angle;
      EXPECT_NEAR(norm(said->pose.R.x - pose.R.x), 0.0, 1e-5) << angle;
      EXPECT_LT(said->rms, 1e-6);
    }
  }
}

TEST(CameraLens, AFisheyeDetectsTagsBesideAndBehindThePlaneOfItsPicture) {
  Team team;
  const BodyId eye = team.add(Multirotor{}, {.name = "eye"}),
               tagged = team.add(Multirotor{}, {.name = "tagged"});
  CameraOptions options;
  options.cameras = {{.observer = eye,
                      .mount = {.pitch = 0.0, .offset = 0.0},
                      .camera = {.width = 1600,
                                 .height = 1600,
                                 .field_of_view = 2 * pi,
                                 .distortion = Distortion::equidistant,
                                 .coefficients = {0, 0, 0, 0}}}};
  options.tags = {{tagged, {.size = 0.4}}};
  const auto found_at = [&](const Distortion lens, double angle) {
    CameraOptions with = options;
    with.cameras[0].camera.distortion = lens;
    if (lens == Distortion::none) {
      with.cameras[0].camera.field_of_view = 2.5;
      with.cameras[0].camera.coefficients = {};
    }
    SyntheticDetections source(team, with);
    RigidPose pose = tag_facing({1.0 * std::cos(angle), 1.0 * std::sin(angle), 0.0});
    const std::vector<ExposedBody> bodies = {{{}, {}}, {pose, pose}};
    int count = 0;
    for (int k = 0; k < 200; ++k) {
      std::vector<Detection> found(1);
      if (source.find({.camera = 0, .time = 0.03 * k, .bodies = bodies}, found) == 0) continue;
      ++count;
      const double error = norm(found[0].p - pose.p);
      EXPECT_LT(error, 0.1) << angle;
    }
    return count;
  };
  for (const double angle : {0.0, 1.0, 1.66, 2.6})
    EXPECT_GT(found_at(Distortion::equidistant, angle), 150) << angle;
  EXPECT_GT(found_at(Distortion::none, 0.0), 150);
  EXPECT_EQ(found_at(Distortion::none, 1.66), 0);
}

}  // namespace
}  // namespace sightline
