#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "sightline/sensors.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/seeing_world.hpp"
#include "tests/support/two_robots.hpp"

namespace sightline {
namespace {

using test::SeeingWorld;
using test::two_robots;

const std::vector<double> facing = {0, 0, 1, 1, 0, 0, 0, 1.5, 0, 1, 1, 0, 0, 0};

CameraOptions options_of(const Camera& camera) {
  CameraOptions options;
  options.cameras = {{.observer = BodyId{0}, .mount = {.pitch = 0.0, .offset = 0.0}, .camera = camera}};
  options.tags = {{BodyId{1}, {}}};
  return options;
}

CameraWorld world_of(const CameraOptions& options) {
  return {std::make_unique<ModelWorld>(two_robots(), facing), options,
          std::make_unique<SyntheticDetections>(two_robots(), options)};
}

/// All that arrives in so many periods of 10 ms.
std::vector<Detection> fly(CameraWorld& world, int periods, std::vector<double>* arrivals = nullptr) {
  std::vector<Detection> all;
  const std::vector<double> u(8, 0.0);
  for (int k = 0; k < periods; ++k) {
    const Measured now = world.measure(0.01 * k);
    EXPECT_LE(now.detections.size(), world.measured_max().detections);
    for (const Detection& one : now.detections) {
      all.push_back(one);
      if (arrivals != nullptr) arrivals->push_back(0.01 * k);
    }
    EXPECT_TRUE(test::apply(world, 0.01 * k, now.measured, u, 0.01, 1));
  }
  return all;
}

TEST(CameraWorld, PicturesComeAtTheirRateAndArriveAfterTheirLatency) {
  CameraWorld world = world_of(options_of({}));
  std::vector<double> arrivals;
  const std::vector<Detection> seen = fly(world, 1000, &arrivals);
  EXPECT_NEAR(static_cast<double>(seen.size()), 298, 8) << "30 Hz over 10 s, 99 % found";
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const double latency = seen[k].arrival - seen[k].stamp;
    EXPECT_GE(latency, 0.03);
    EXPECT_LE(latency, 0.08);
    EXPECT_GE(arrivals[k], seen[k].arrival - 1e-9);
    EXPECT_LT(arrivals[k], seen[k].arrival + 0.01);
    if (k > 0 && arrivals[k] == arrivals[k - 1]) {
      EXPECT_GE(seen[k].arrival, seen[k - 1].arrival) << "in the order of arrival";
    }
    EXPECT_EQ(seen[k].observer, BodyId{0});
    EXPECT_NEAR(seen[k].p.x, 1.5, 0.05);
  }
}

TEST(CameraWorld, OfATagItMayTellThePositionAlone) {
  CameraWorld whole = world_of(options_of({})),
              part = world_of(options_of({.output = CameraOutput::position}));
  const std::vector<Detection> poses = fly(whole, 100), positions = fly(part, 100);
  ASSERT_EQ(poses.size(), positions.size());
  ASSERT_FALSE(poses.empty());
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_TRUE(poses[k].is_oriented());
    EXPECT_FALSE(positions[k].is_oriented());
    EXPECT_EQ(poses[k].p.x, positions[k].p.x);
    const Mat<6, 6> P = positions[k].covariance_matrix();
    EXPECT_GT(P(0, 0), 0.0);
    EXPECT_EQ(P(0, 0), poses[k].covariance_matrix()(0, 0));
    EXPECT_EQ(P(0, 4), 0.0);
    EXPECT_EQ(P(5, 5), 0.0);
  }
}

TEST(CameraWorld, PicturesThatAreLostAreNotSeen) {
  CameraWorld world = world_of(options_of({.dropout = 0.3}));
  EXPECT_NEAR(static_cast<double>(fly(world, 3000).size()), 900 * 0.7 * 0.99, 65);
}

TEST(CameraWorld, GivesTheStatesOfTheWorldAsTheyAre) {
  ModelWorld plain(two_robots(), facing);
  CameraWorld seen = world_of(options_of({}));
  const std::vector<double> u(8, 0.1);
  for (int k = 0; k < 50; ++k) {
    const Measured a = plain.measure(0.01 * k), b = seen.measure(0.01 * k);
    EXPECT_TRUE(std::equal(a.measured.begin(), a.measured.end(), b.measured.begin()));
    EXPECT_TRUE(std::equal(a.truth.begin(), a.truth.end(), b.truth.begin()));
    EXPECT_TRUE(std::equal(a.stamps.begin(), a.stamps.end(), b.stamps.begin()));
    test::apply(plain, 0.01 * k, a.measured, u, 0.01, 1);
    test::apply(seen, 0.01 * k, b.measured, u, 0.01, 1);
  }
  EXPECT_EQ(seen.ended(), "");
  EXPECT_EQ(&seen.team(), &seen.seen().team());
}

TEST(CameraWorld, ACameraOnTheBodyLeansAsTheInputsInForceSay) {
  CameraOptions options = options_of({.rate = 100.0, .latency = {0.0, 0.0}});
  options.cameras[0].mount.frame = MountFrame::body;
  CameraWorld world = world_of(options);
  std::vector<double> u(8, 0.0);
  u[0] = 0.5;  // ahead: the nose goes down, and what is ahead is above the axis
  (void)world.measure(0.0);
  EXPECT_TRUE(test::apply(world, 0.0, facing, u, 0.01, 1));
  const Measured now = world.measure(0.01);
  ASSERT_EQ(now.detections.size(), 1U);
  const Vec2<double> lean = two_robots().model(BodyId{0}).sight(now.truth.data(), u.data()).lean;
  EXPECT_GT(lean.x, 0.05);
  EXPECT_NEAR(now.detections[0].p.z / now.detections[0].p.x, lean.x, 0.01);
}

TEST(CameraWorld, OfABodyThatLeftNothingArrives) {
  CameraWorld world = world_of(options_of({}));
  std::vector<Presence> presence(2, Presence::steered);
  world.set_presence(presence);
  EXPECT_FALSE(fly(world, 20).empty());
  presence[1] = Presence::absent;
  world.set_presence(presence);
  const std::vector<double> u(8, 0.0);
  for (int k = 20; k < 60; ++k) {
    EXPECT_TRUE(world.measure(0.01 * k).detections.empty()) << k;
    test::apply(world, 0.01 * k, facing, u, 0.01, 1);
  }
  presence[1] = Presence::steered;
  world.set_presence(presence);
  std::size_t seen = 0;
  for (int k = 60; k < 100; ++k) {
    const Measured now = world.measure(0.01 * k);
    seen += now.detections.size();
    for (const Detection& one : now.detections) EXPECT_GE(one.stamp, 0.6);
    test::apply(world, 0.01 * k, now.measured, u, 0.01, 1);
  }
  EXPECT_GT(seen, 8U);
}

TEST(CameraWorld, PicturesOfMissedPeriodsAreNotTakenLater) {
  CameraWorld world = world_of(options_of({.latency = {0.0, 0.0}}));
  const std::vector<double> u(8, 0.0);
  EXPECT_LE(world.measure(0.0).detections.size(), 1U);
  test::apply(world, 0.0, facing, u, 0.01, 50);
  EXPECT_LE(world.measure(0.5).detections.size(), 1U);
  test::apply(world, 0.5, facing, u, 0.01, 1);
  EXPECT_TRUE(world.measure(0.51).detections.empty());
}

TEST(CameraWorld, RefusesWhatCannotBeSeenThrough) {
  const auto world = [] { return std::make_unique<ModelWorld>(two_robots(), facing); };
  const auto source = [](const CameraOptions& options) {
    return std::make_unique<SyntheticDetections>(two_robots(), options);
  };
  const CameraOptions good = options_of({});
  CameraOptions bad = good;
  bad.tags[0].body = BodyId{2};
  EXPECT_THAT(refusal_of([&] { CameraWorld(world(), bad, source(good)); }),
              testing::HasSubstr("a hull of body 2, expected one of the team's 2"));
  EXPECT_THAT(refusal_of([&] { CameraWorld(world(), options_of({.rate = -1}), source(good)); }),
              testing::HasSubstr("camera.rate = -1"));
  EXPECT_THAT(refusal_of([&] {
                CameraWorld(std::make_unique<SeeingWorld>(two_robots(), facing), good, source(good));
              }),
              testing::HasSubstr("detections of its own"));
}

}  // namespace
}  // namespace sightline
