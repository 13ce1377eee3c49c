#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/sensors.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

constexpr double degree = std::numbers::pi / 180;
const Camera usual_camera;
const Tags usual_tags;

/// A body d m ahead, turned by `az` from showing its first face, seen from above by `el`.
RigidPose pose_at(double d, double az, double el) {
  return {{d, 0.1 * d, -0.05 * d},
          compose(turn_by({0, el * degree, 0}), turn_by({0, 0, std::numbers::pi + az * degree}))};
}

std::vector<FoundTag> pictured(const RigidPose& pose, double sigma, RandomStream& chance) {
  std::vector<FoundTag> all;
  for (int face = 0; face < usual_tags.faces; ++face) {
    const Vec3<double> centre = pose.p + pose.R.to_G(usual_tags.centre(face));
    if (-dot(pose.R.to_G(usual_tags.normal(face)), centre) / norm(centre) < std::cos(65 * degree)) continue;
    FoundTag& tag = all.emplace_back(FoundTag{face, {}});
    const auto corners = usual_tags.corners(face);
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2<double> at = usual_camera.project(pose.p + pose.R.to_G(corners[i]));
      tag.corners[i] = {at.x + sigma * chance.normal(), at.y + sigma * chance.normal()};
    }
  }
  return all;
}

double angle(const Rotation& a, const Rotation& b) {
  const Rotation d = between(a, b);
  return std::acos(std::clamp(0.5 * (d.x.x + d.y.y + d.z.z - 1), -1.0, 1.0));
}

TEST(TagPose, IsFoundFromExactCornersWithoutAGuess) {
  RandomStream chance(1, StreamId::sighting, 0);
  for (const double d : {0.5, 1.0, 2.0, 3.0}) {
    for (const double az : {-40.0, 5.0, 20.0, 45.0}) {
      for (const double el : {0.0, 28.0}) {
        const RigidPose pose = pose_at(d, az, el);
        const auto found = pictured(pose, 0.0, chance);
        ASSERT_FALSE(found.empty());
        const auto said = pose_of(usual_camera, usual_tags, found, pose.R.z);
        ASSERT_TRUE(said);
        EXPECT_NEAR(norm(said->pose.p - pose.p), 0.0, 1e-6) << d << " " << az << " " << el;
        EXPECT_NEAR(angle(said->pose.R, pose.R), 0.0, 1e-5) << d << " " << az << " " << el;
        EXPECT_LT(said->rms, 1e-6);
      }
    }
  }
}

TEST(TagPose, OfNoCornersOrCornersOfNoSquareIsNone) {
  EXPECT_FALSE(pose_of(usual_camera, usual_tags, {}, {0, 0, 1}));
  const std::vector<FoundTag> flat = {FoundTag{0, {{{0, 0}, {1, 0}, {2, 0}, {3, 0}}}}};
  EXPECT_FALSE(pose_of(usual_camera, usual_tags, flat, {0, 0, 1}));
}

/// The errors of poses from noisy corners have the covariance that is said: their squares by it
/// have the mean of a chi^2 of 6.
TEST(PoseInformation, SaysTheCovarianceOfPosesFromNoisyCorners) {
  RandomStream chance(5, StreamId::sighting, 0);
  for (const double d : {0.8, 1.2}) {
    for (const double az : {25.0, 45.0}) {
      const RigidPose pose = pose_at(d, az, 15);
      const double sigma =
          corner_sigma(usual_camera.pixels(usual_tags.size, d), 1.0, usual_camera.noise, 0.0);
      double sum = 0.0;
      constexpr int pictures = 400;
      for (int k = 0; k < pictures; ++k) {
        const auto found = pictured(pose, sigma, chance);
        const auto said = refined(usual_camera, usual_tags, found, pose);
        ASSERT_TRUE(said);
        PoseInformation information(usual_camera, usual_tags, said->pose);
        for (const FoundTag& tag : found) information.add(tag.face, sigma);
        const auto covariance = information.covariance();
        ASSERT_TRUE(covariance);
        // The truth after what is said.
        const Vec3<double> dp = pose.p - said->pose.p;
        const Quaternion q = quaternion(compose(pose.R, between(said->pose.R, Rotation{})));
        sum += mahalanobis<6>({{{{dp.x}, {dp.y}, {dp.z}, {2 * q.x}, {2 * q.y}, {2 * q.z}}}}, *covariance);
      }
      EXPECT_NEAR(sum / pictures, 6.0, 0.7) << d << " m, " << az << " degrees";
    }
  }
}

TEST(PoseInformation, AgreesWithTheFiguresOfRenderedPictures) {
  for (const double d : {0.75, 1.0, 1.5, 2.0}) {
    const double n = usual_camera.pixels(usual_tags.size, d);
    for (const double az : {20.0, 30.0}) {
      const RigidPose pose = {{d, 0, 0}, turn_by({0, 0, std::numbers::pi + az * degree})};
      PoseInformation one(usual_camera, usual_tags, pose);
      one.add(0, corner_sigma(n, 1.0, usual_camera.noise, 0.0));
      const auto covariance = one.covariance();
      ASSERT_TRUE(covariance);
      const double of_range = std::sqrt((*covariance)(0, 0)) / d, of_yaw = std::sqrt((*covariance)(5, 5));
      EXPECT_NEAR(of_range * n * n / 1.7, 1.2, 0.4) << "sigma_r / r = 1.7 / n^2, at " << d << " m";
      EXPECT_NEAR(of_yaw * n * n / 5.0, 1.2, 0.7) << "sigma_yaw = 5 / n^2, at " << d << " m";
    }
  }
}

TEST(PoseInformation, SeveralTagsSayMoreThanOneAndNoneNothing) {
  const RigidPose pose = pose_at(1.0, 45, 0);
  PoseInformation none(usual_camera, usual_tags, pose), one(usual_camera, usual_tags, pose),
      both(usual_camera, usual_tags, pose);
  one.add(0, 0.1);
  both.add(0, 0.1);
  both.add(3, 0.1);
  const auto of_one = one.covariance(), of_both = both.covariance();
  EXPECT_FALSE(none.covariance());
  ASSERT_TRUE(of_one && of_both);
  for (int i = 0; i < 6; ++i) EXPECT_LT((*of_both)(i, i), (*of_one)(i, i));
}

TEST(Mirrored, KeepsTheTagAndTurnsThePlateToTheOtherSide) {
  const RigidPose pose = pose_at(1.5, 15, 0), other = mirrored(usual_tags, 0, pose);
  const auto centre = [&](const RigidPose& of) { return of.p + of.R.to_G(usual_tags.centre(0)); };
  EXPECT_NEAR(norm(centre(pose) - centre(other)), 0.0, 1e-12);
  const Vec3<double> sight = (-1 / norm(centre(pose))) * centre(pose);
  EXPECT_NEAR(dot(pose.R.to_G(usual_tags.normal(0)), sight), dot(other.R.to_G(usual_tags.normal(0)), sight),
              1e-12);
  EXPECT_GT(angle(pose.R, other.R), 20 * degree);
  const RigidPose back = mirrored(usual_tags, 0, other);
  EXPECT_NEAR(norm(back.p - pose.p), 0.0, 1e-12);
  EXPECT_NEAR(angle(back.R, pose.R), 0.0, 1e-7);
}

TEST(CornerSigma, GrowsWithDistanceSlantNoiseAndSmear) {
  EXPECT_NEAR(corner_sigma(41.6, 1.0, 4.0, 0.0), 0.05 + 30 / (41.6 * 41.6), 1e-12);
  EXPECT_GT(corner_sigma(20, 1, 4, 0), corner_sigma(40, 1, 4, 0));
  EXPECT_GT(corner_sigma(20, 1, 8, 0), corner_sigma(20, 1, 4, 0));
  EXPECT_NEAR(corner_sigma(20, 1, 4, 3), 2 * corner_sigma(20, 1, 4, 0), 1e-12);
  EXPECT_EQ(corner_sigma(20, 0.8, 4, 0), corner_sigma(20, 1, 4, 0));
  EXPECT_GT(corner_sigma(20, 0.5, 4, 0), 1.5 * corner_sigma(20, 1, 4, 0)) << "seen from the side";
}

}  // namespace
}  // namespace sightline
