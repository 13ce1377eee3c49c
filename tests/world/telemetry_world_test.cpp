#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sightline/estimator.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

constexpr double tick = 0.01;

/// Two robots at rest, 2 m apart, the second turned by 1 rad.
std::unique_ptr<World> pair_at_rest() {
  Team team;
  team.add(Multirotor{}, {.name = "a"});
  team.add(Multirotor{}, {.name = "b"});
  return std::make_unique<ModelWorld>(
      team, std::vector<double>{0, 0, 1, 1, 0, 0, 0, 2, 0, 1, std::cos(1.0), std::sin(1.0), 0, 0},
      PlantOptions{});
}

struct Heard {
  std::vector<RobotMotion> motions;
  std::vector<std::pair<double, BodyBroadcast>> broadcasts;  // with the time of arrival
};
Heard listen(TelemetryWorld& world, int periods, std::vector<double> u = std::vector<double>(8)) {
  Heard received;
  for (int k = 0; k < periods; ++k) {
    const Measured now = world.measure(k * tick);
    EXPECT_LE(now.motions.size(), world.measured_max().motions);
    EXPECT_LE(now.broadcasts.size(), world.measured_max().broadcasts);
    received.motions.insert(received.motions.end(), now.motions.begin(), now.motions.end());
    for (const BodyBroadcast& one : now.broadcasts) received.broadcasts.emplace_back(k * tick, one);
    EXPECT_TRUE(test::apply(world, k * tick, now.measured, u, tick, 1));
  }
  return received;
}

TEST(TelemetryWorld, ARobotTellsItsMotionEachPeriodAfterTheFirst) {
  TelemetryWorld world(pair_at_rest(), {.robots = {{BodyId{1}, {}}}});
  std::vector<double> u(8);
  u[4] = 0.5;  // b flies ahead
  const Heard received = listen(world, 200, u);
  ASSERT_EQ(received.motions.size(), 199U);
  double v = 0.0;
  for (const RobotMotion& one : received.motions) {
    EXPECT_EQ(one.robot, BodyId{1});
    EXPECT_NEAR(one.motion.dt, tick, 1e-12);
    v += one.motion.v_V.x / 199;
  }
  EXPECT_GT(v, 0.2) << "ahead is along its own heading";
  EXPECT_TRUE(received.broadcasts.empty());
}

TEST(TelemetryWorld, ABodyBroadcastsItsPoseAtItsRateWithItsErrors) {
  TelemetryWorld world(
      pair_at_rest(),
      {.broadcasters = {BodyId{1}}, .radio = {.rate = 20.0, .position_sigma = 0.03, .heading_sigma = 0.1}});
  const Heard received = listen(world, 4000);
  ASSERT_EQ(received.broadcasts.size(), 800U);
  double x = 0.0, squares = 0.0, psi = 0.0, turns = 0.0;
  for (const auto& [arrival, one] : received.broadcasts) {
    EXPECT_EQ(arrival, one.pose.stamp);
    EXPECT_EQ(one.pose.P(0, 0), 0.03 * 0.03);
    EXPECT_NEAR(one.pose.P(3, 3), 0.01, 1e-15);
    x += one.pose.p.x / 800, squares += std::pow(one.pose.p.x - 2, 2) / 800;
    psi += one.pose.psi / 800, turns += std::pow(one.pose.psi - 1, 2) / 800;
  }
  EXPECT_NEAR(x, 2.0, 0.005);
  EXPECT_NEAR(std::sqrt(squares), 0.03, 0.003);
  EXPECT_NEAR(psi, 1.0, 0.02);
  EXPECT_NEAR(std::sqrt(turns), 0.1, 0.01);
}

TEST(TelemetryWorld, MessagesComeLateAndSomeAreLost) {
  TelemetryWorld world(pair_at_rest(),
                       {.broadcasters = {BodyId{0}}, .radio = {.latency = {0.05, 0.2}, .dropout = 0.3}});
  const Heard received = listen(world, 4000);
  EXPECT_NEAR(static_cast<double>(received.broadcasts.size()), 0.7 * 4000, 100);
  for (const auto& [arrival, one] : received.broadcasts) {
    EXPECT_GE(arrival - one.pose.stamp, 0.05 - 1e-9);
    EXPECT_LE(arrival - one.pose.stamp, 0.2 + tick);
  }
}

TEST(TelemetryWorld, OneThatIsAbsentTellsNothingAndComesAgainWithoutAJump) {
  TelemetryWorld world(
      pair_at_rest(),
      {.robots = {{BodyId{1}, {}}}, .broadcasters = {BodyId{0}}, .radio = {.latency = {0.1, 0.1}}});
  const auto presence = [&](Presence of_both) { world.set_presence(std::vector{of_both, of_both}); };
  (void)listen(world, 50);
  presence(Presence::absent);
  for (int k = 50; k < 60; ++k) {
    const Measured now = world.measure(k * tick);
    EXPECT_TRUE(now.motions.empty());
    EXPECT_TRUE(now.broadcasts.empty());
    EXPECT_TRUE(test::apply(world, k * tick, now.measured, std::vector<double>(8), tick, 1));
  }
  presence(Presence::steered);
  EXPECT_TRUE(world.measure(0.6).motions.empty()) << "where it was before is not where it comes to be";
  EXPECT_TRUE(test::apply(world, 0.6, world.start(), std::vector<double>(8), tick, 1));
  EXPECT_EQ(world.measure(0.61).motions.size(), 1U);
}

TEST(TelemetryWorld, ItsChanceIsEachBodysOwn) {
  const auto first = [](const TelemetryOptions& options) {
    TelemetryWorld world(pair_at_rest(), options);
    const Heard received = listen(world, 10);
    for (const auto& [arrival, one] : received.broadcasts)
      if (one.body == BodyId{1}) return one.pose.p.x;
    return 0.0;
  };
  const double alone = first({.seed = 5, .broadcasters = {BodyId{1}}});
  EXPECT_EQ(alone, first({.seed = 5, .robots = {{BodyId{0}, {}}}, .broadcasters = {BodyId{0}, BodyId{1}}}));
  EXPECT_NE(alone, first({.seed = 6, .broadcasters = {BodyId{1}}}));
}

TEST(TelemetryWorld, WhatCannotBeIsRefused) {
  const auto refused = [](const TelemetryOptions& options) {
    return refusal_of([&] { TelemetryWorld(pair_at_rest(), options); });
  };
  EXPECT_EQ(refused({.robots = {{BodyId{2}, {}}}}), "telemetry of body 2, expected one of the team's 2");
  EXPECT_EQ(refused({.radio = {.rate = 0.0}}), "radio.rate = 0, expected 0.1 to 1000 Hz");
  EXPECT_EQ(refused({.radio = {.latency = {0.2, 0.1}}}), "latency = [0.2, 0.1], expected the shortest first");
  EXPECT_EQ(refusal_of([] {
              TelemetryWorld(std::make_unique<TelemetryWorld>(pair_at_rest(),
                                                              TelemetryOptions{.broadcasters = {BodyId{0}}}),
                             TelemetryOptions{});
            }),
            "the world gives telemetry of its own, expected one without");
}

TEST(TelemetryWorld, TheErrorsOfMessagesHaveTheStatedAutocorrelation) {
  constexpr int seeds = 400;
  constexpr double time = 0.5;
  const std::array<std::size_t, 3> at = {0, 3, 7};  // of messages at 10 Hz
  std::array<std::array<double, 3>, 3> mean{};
  for (int seed = 0; seed < seeds; ++seed) {
    TelemetryWorld world(pair_at_rest(), {.seed = static_cast<std::uint64_t>(seed),
                                          .broadcasters = {BodyId{1}},
                                          .radio = {.rate = 10.0, .correlation_time = time}});
    const Heard received = listen(world, 80);
    ASSERT_EQ(received.broadcasts.size(), 8U);
    const auto errors = [&](std::size_t k) {
      const BroadcastPose& pose = received.broadcasts[k].second.pose;
      return std::array{(pose.p.x - 2) / 0.01, pose.p.y / 0.01, (pose.p.z - 1) / 0.01, pose.v.x / 0.03,
                        pose.v.y / 0.03,       pose.v.z / 0.03, (pose.psi - 1) / 0.01};
    };
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t a = 0; a < 7; ++a) mean[i][j] += errors(at[i])[a] * errors(at[j])[a] / (7 * seeds);
  }
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double lag = 0.1 * std::abs(static_cast<double>(at[i]) - static_cast<double>(at[j]));
      EXPECT_NEAR(mean[i][j], std::exp(-lag / time), 4.5 * std::sqrt(2.0 / (7 * seeds))) << lag;
    }
}

}  // namespace
}  // namespace sightline
