#ifdef SIGHTLINE_PICTURES
#include "worlds/mujoco/camera/rendered_detections.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/scenario.hpp"
#include "sightline/sensors.hpp"
#include "tests/mujoco/team.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/two_robots.hpp"

namespace sightline {
namespace {

using mujoco::RenderedDetections;

/// Robot a looks along x at robot b; a pillar stands aside.
struct Pictured {
  Team team = test::two_robots();
  CameraOptions options{};
  std::vector<ExposedBody> bodies{3};
  std::vector<Detection> found{1};

  Pictured() {
    team.add(Obstacle{"pillar"});
    options.cameras = {{.observer = BodyId{0}, .mount = {.pitch = 0.0, .offset = 0.0}, .render = true}};
    options.tags = {{BodyId{1}, {}}};
    options.hulls = {{BodyId{0}, {.radius = 0.3}}, {BodyId{2}, {.radius = 0.2, .height = 2.0}}};
    bodies[0].now.p = {0, 0, 1.5};
    bodies[2].now.p = {1, 2, 1};
    place({1.5, 0.1, 1.4}, 0.5);
    bodies[0].before = bodies[0].now;
  }
  /// @param yaw  from showing its first face to the camera [rad]
  void place(const Vec3<double>& p, double yaw) {
    bodies[1].now = bodies[1].before = {p, turn_by({0, 0, std::numbers::pi + yaw})};
  }
  RigidPose truth() const {
    return seen_from(sensor_pose(options.cameras[0].mount, bodies[0].now), bodies[1].now);
  }
  Exposure exposure() const { return {0, 0.0, 0.01, bodies}; }
};

TEST(RenderedDetections, AgreeWithTheModelOfTheirNoiseOverDistanceAndAngle) {
  Pictured scene;
  RenderedDetections rendered(scene.team, scene.options);
  double sum = 0.0, count = 0.0;
  int mistaken = 0;
  for (const double d : {0.9, 1.5, 2.2}) {
    for (const double yaw : {0.45, 0.6, 0.78}) {
      double bias = 0.0;
      constexpr int pictures = 4;
      for (int k = 0; k < pictures; ++k) {
        scene.place({d, 0.05 * k, 1.5 - 0.03 * k}, yaw + 0.01 * k);
        ASSERT_EQ(rendered.find(scene.exposure(), scene.found), 1U) << d << " m, " << yaw << " rad";
        const Detection& seen = scene.found[0];
        const RigidPose truth = scene.truth();
        const Vec3<double> dp = truth.p - seen.p;
        const Quaternion q = quaternion(compose(truth.R, between(rotation(seen.q), Rotation{})));
        const double length = mahalanobis<6>({{{{dp.x}, {dp.y}, {dp.z}, {2 * q.x}, {2 * q.y}, {2 * q.z}}}},
                                             seen.covariance_matrix());
        if (length > 60) {  // the other solution of a tag
          ++mistaken;
          continue;
        }
        sum += length;
        ++count;
        bias += (norm(seen.p) / norm(truth.p) - 1) / pictures;
        EXPECT_LT(norm(dp), 0.02 * d);
      }
      EXPECT_LT(std::abs(bias), 0.01) << d << " m, " << yaw << " rad";
    }
  }
  EXPECT_LE(mistaken, 2);
  EXPECT_GT(sum / count, 1.5) << "6 where the model is right";
  EXPECT_LT(sum / count, 12.0);
}

TEST(RenderedDetections, WhatIsHiddenSmearedOrGoneIsNotSeen) {
  Pictured scene;
  RenderedDetections rendered(scene.team, scene.options);
  const auto seen = [&] { return rendered.find(scene.exposure(), scene.found); };
  EXPECT_EQ(seen(), 1U);
  scene.bodies[2].now.p = {0.8, 0.05, 1.0};
  EXPECT_EQ(seen(), 0U) << "behind the pillar";
  scene.bodies[2].there = false;
  EXPECT_EQ(seen(), 1U) << "which is not there";
  scene.bodies[1].before.p.y += 0.15;  // 15 m/s
  EXPECT_EQ(seen(), 0U) << "smeared";
  scene.bodies[1].before = scene.bodies[1].now;
  scene.bodies[1].there = false;
  EXPECT_EQ(seen(), 0U);
  scene.bodies[1].there = true;
  scene.bodies[0].there = false;
  EXPECT_EQ(seen(), 0U) << "nobody looks";
}

TEST(RenderedDetections, AreTheSameBytesAgainAndShowTheTag) {
  Pictured scene;
  RenderedDetections one(scene.team, scene.options), other(scene.team, scene.options);
  std::vector<Detection> again(1);
  for (int k = 0; k < 3; ++k) {
    scene.place({1.5, 0.02 * k, 1.4}, 0.5);
    ASSERT_EQ(one.find(scene.exposure(), scene.found), 1U);
    ASSERT_EQ(other.find(scene.exposure(), again), 1U);
    EXPECT_EQ(scene.found[0].p.x, again[0].p.x);
    EXPECT_EQ(scene.found[0].q, again[0].q);
    EXPECT_EQ(scene.found[0].covariance, again[0].covariance);
  }
  const auto picture = one.picture(0).bytes();
  EXPECT_EQ(picture.size(), 320U * 240U);
  EXPECT_GT(*std::max_element(picture.begin(), picture.end()), 180) << "white of a tag";
  EXPECT_LT(*std::min_element(picture.begin(), picture.end()), 40) << "and its black";
}

TEST(RenderedDetections, CamerasOfARobotHaveErrorsOfTheirOwn) {
  Pictured scene;
  scene.options.cameras.push_back(scene.options.cameras[0]);
  RenderedDetections rendered(scene.team, scene.options);
  std::vector<Detection> other(1);
  ASSERT_EQ(rendered.find(scene.exposure(), scene.found), 1U);
  Exposure further = scene.exposure();
  further.camera = 1;
  ASSERT_EQ(rendered.find(further, other), 1U);
  EXPECT_NE(scene.found[0].p.x, other[0].p.x);
  EXPECT_LT(norm(scene.found[0].p - other[0].p), 0.05);
}

TEST(RenderedDetections, CamerasThatDoNotRenderSeeAsTheModelSays) {
  Pictured scene;
  scene.options.cameras[0].render = false;
  RenderedDetections rendered(scene.team, scene.options);
  SyntheticDetections synthetic(scene.team, scene.options);
  std::vector<Detection> drawn(1);
  ASSERT_EQ(rendered.find(scene.exposure(), scene.found), 1U);
  ASSERT_EQ(synthetic.find(scene.exposure(), drawn), 1U);
  EXPECT_EQ(scene.found[0].p.x, drawn[0].p.x);
}

TEST(RenderedDetections, MoreTagsThanTheFamilyHasAreRefused) {
  Pictured scene;
  scene.options.tags.assign(80, {BodyId{1}, {.faces = 8}});
  EXPECT_EQ(refusal_of([&] { RenderedDetections(scene.team, scene.options); }),
            "the bodies have 640 tags, tag36h11 has 587");
}

TEST(RenderedDetections, AScenarioFliesOnThemInTheWorldOfMuJoCo) {
  Registry registry;
  add_mujoco(registry);
  const Scenario scenario = parse_scenario(R"toml([world]
kind = "mujoco"

[agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0 }

[agent.a.sensor]
pitch = 0.0
offset = 0.17
frame = "body"

[agent.a.camera]
render = true
latency = [0.03, 0.03]

[agent.b]
robot = "multirotor"
start = { p = [1.6, 0.0, 1.0], heading = 0.6 }

[agent.b.tags]
)toml",
                                           "a.toml", registry);
  const auto world = make_world(scenario);
  const std::vector<double> u(8, 0.0);
  std::size_t seen = 0;
  for (int k = 0; k < 50; ++k) {
    const Measured now = world->measure(0.01 * k);
    for (const Detection& one : now.detections) {
      ++seen;
      EXPECT_NEAR(one.p.x, 1.43, 0.03);
      EXPECT_NEAR(one.arrival - one.stamp, 0.03, 1e-9);
    }
    ASSERT_TRUE(test::apply(*world, 0.01 * k, now.measured, u, 0.01, 1));
  }
  EXPECT_GE(seen, 12U) << "30 Hz, over 0.47 s";
}

}  // namespace
}  // namespace sightline
#endif
