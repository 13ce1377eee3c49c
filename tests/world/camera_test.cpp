#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/sensors.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(Camera, ItsFocalLengthSaysHowLargeATagIs) {
  const Camera camera;
  EXPECT_NEAR(camera.focal(), 207.8, 0.1);
  EXPECT_NEAR(camera.pixels(0.2, 1.0), 41.6, 0.1);
  const Vec2<double> at = camera.project({2.0, 0.5, -0.25});
  EXPECT_NEAR(at.x, -0.25 * camera.focal(), 1e-9) << "what is to the left is left in the picture";
  EXPECT_NEAR(at.y, 0.125 * camera.focal(), 1e-9) << "and what is below is further down";
}

TEST(Camera, RefusesWhatIsNoCamera) {
  EXPECT_THAT(refusal_of([] {
                Camera{.latency = {0.08, 0.03}}.check();
              }),
              HasSubstr("camera.latency = [0.08, 0.03] s, expected the shortest first"));
  EXPECT_THAT(refusal_of([] { Camera{.rate = 0}.check(); }), HasSubstr("camera.rate = 0, expected"));
  EXPECT_THAT(refusal_of([] { Tags{.faces = 9}.check(); }), HasSubstr("tags.faces = 9, expected 1 to 8"));
}

TEST(Tags, StandUprightAroundTheBodyTheFirstAhead) {
  const Tags tags{.size = 0.2, .faces = 4, .distance = 0.1, .height = 0.05};
  EXPECT_NEAR(tags.centre(0).x, 0.1, 1e-12);
  EXPECT_NEAR(tags.centre(1).y, 0.1, 1e-12) << "the second to the left";
  for (int face = 0; face < tags.faces; ++face) {
    const auto c = tags.corners(face);
    // Seen from outside, anticlockwise from the bottom left.
    const Vec3<double> turn = cross(c[1] - c[0], c[3] - c[0]);
    EXPECT_NEAR(dot(turn, tags.normal(face)), 0.04, 1e-12);
    EXPECT_LT(c[0].z, c[3].z);
    EXPECT_NEAR(norm(0.25 * (c[0] + c[1] + c[2] + c[3]) - tags.centre(face)), 0.0, 1e-12);
  }
}

TEST(SensorPose, IsTheFrameOfTheMountLevelAndLeaning) {
  Random random(3);
  for (const MountFrame frame : {MountFrame::level, MountFrame::body}) {
    for (int k = 0; k < 200; ++k) {
      const SensorMount mount = random_mount(random, frame);
      const double psi = uniform(random, -3.0, 3.0);
      const Sight<double> sight{
          {{uniform(random, -2.0, 2.0), uniform(random, -2.0, 2.0), uniform(random, 0.0, 2.0)},
           {std::cos(psi), std::sin(psi)}},
          {},
          {uniform(random, -0.3, 0.3), uniform(random, -0.3, 0.3)}};
      const RigidPose S = sensor_pose(mount, {sight.p, rotation(leaning(sight.d, sight.lean))});
      const Vec3<double> point{uniform(random, -2.0, 2.0), uniform(random, -2.0, 2.0),
                               uniform(random, 0.0, 2.0)};
      const Vec3<double> p = S.R.to_B(point - S.p), expected = mount(sight, point);
      EXPECT_NEAR(norm(p - expected), 0.0, 1e-12);
    }
  }
}

TEST(Hull, APillarHidesMoreThanASphereAndWhatIsRightBelowIt) {
  const Hull sphere{.radius = 0.3}, pillar{.radius = 0.3, .height = 2.0};
  const Vec3<double> middle{1, 0, 1};
  EXPECT_FALSE(sphere.hides(middle, {0, 0, 1.5}, {2, 0, 1.5}));
  EXPECT_TRUE(pillar.hides(middle, {0, 0, 1.5}, {2, 0, 1.5}));
  EXPECT_TRUE(pillar.hides(middle, {1, 0, 3}, {1, 0, -1})) << "along its axis";
  EXPECT_FALSE(pillar.hides(middle, {1.5, 0, 3}, {1.5, 0, -1}));
}

/// The way through, by points along it.
TEST(Hull, HidesAsPointsAlongTheWaySay) {
  Random random(11);
  for (int k = 0; k < 20000; ++k) {
    const Hull hull{.radius = uniform(random, 0.1, 0.6),
                    .height = k % 2 == 0 ? 0.0 : uniform(random, 0.2, 2.0)};
    const auto point = [&] {
      return Vec3<double>{uniform(random, -2.0, 2.0), uniform(random, -2.0, 2.0), uniform(random, -2.0, 2.0)};
    };
    const Vec3<double> a = point(), b = point();
    const auto depth = [&](const Vec3<double>& p) {  // > 0 within
      const double across = hull.radius - std::hypot(p.x, p.y);
      return hull.height > 0 ? std::min(across, 0.5 * hull.height - std::abs(p.z)) : hull.radius - norm(p);
    };
    if (depth(a) > 0 || depth(b) > 0) {
      EXPECT_FALSE(hull.hides({}, a, b));
      continue;
    }
    double deepest = -1;
    for (int i = 0; i <= 400; ++i) deepest = std::max(deepest, depth(a + (i / 400.0) * (b - a)));
    if (std::abs(deepest) < 0.02) continue;  // too near to tell
    EXPECT_EQ(hull.hides({}, a, b), deepest > 0) << k;
  }
}

}  // namespace
}  // namespace sightline
