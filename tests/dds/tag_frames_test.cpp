#include "bridges/dds/topics/tag_frames.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sightline/world.hpp"

namespace sightline::dds {
namespace {

TEST(TagFrames, ATagSeenFromAheadHasItsAxesAsAprilTagHasThem) {
  // A body 2 m ahead that looks back at the camera: face 0 is towards it.
  const Tags tags;
  const RigidPose body = {{2, 0, 0}, turn_by({0, 0, std::numbers::pi})};
  const RigidPose on_body = tag_on_body(tags, 0);
  const RigidPose tag = {body.p + body.R.to_G(on_body.p), compose(body.R, on_body.R)};
  const OpticalPose seen = in_optical(tag);
  EXPECT_NEAR(seen.p.x, 0, 1e-12);
  EXPECT_NEAR(seen.p.y, 0, 1e-12);
  EXPECT_NEAR(seen.p.z, 2 - tags.distance, 1e-12);
  // x to the right as in the picture, y up, against the picture's, z towards the camera: half a
  // turn about x.
  const Rotation R = rotation(seen.q);
  EXPECT_NEAR(R.x.x, 1, 1e-12);
  EXPECT_NEAR(R.y.y, -1, 1e-12);
  EXPECT_NEAR(R.z.z, -1, 1e-12);
}

TEST(TagFrames, CornersOfATagAreThoseOfTheBody) {
  const Tags tags{.size = 0.3, .faces = 5};
  for (int face = 0; face < tags.faces; ++face) {
    const RigidPose tag = tag_on_body(tags, face);
    const auto corners = tags.corners(face);
    EXPECT_LT(norm(tag.p + tag.R.to_G({-0.15, -0.15, 0}) - corners[0]), 1e-12);
    EXPECT_LT(norm(tag.p + tag.R.to_G({0.15, 0.15, 0}) - corners[2]), 1e-12);
    EXPECT_LT(norm(tag.R.z - tags.normal(face)), 1e-12);
  }
}

TEST(TagFrames, ThereAndBackIsTheSame) {
  RandomStream chance(3, StreamId::gust, 0);
  for (int k = 0; k < 100; ++k) {
    const RigidPose pose = {chance.normals(), turn_by(chance.normals())};
    const OpticalPose seen = in_optical(pose);
    const RigidPose again = from_optical(seen.p, seen.q);
    EXPECT_LT(norm(again.p - pose.p) + norm(again.R.x - pose.R.x) + norm(again.R.z - pose.R.z), 1e-12);
  }
}

}  // namespace
}  // namespace sightline::dds
