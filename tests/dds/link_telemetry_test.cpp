#include "bridges/dds/links/link_telemetry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "bridges/dds/topics/channel.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"
#include "tests/support/refusal.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using testing::HasSubstr;

const std::string by_attitude_filter = "agent.uav0.estimate.filter=\"attitude\"";

Scenario localized(double duration, const std::vector<std::string>& set = {}) {
  std::vector<std::string> all = {fmt::format("fleet.domain={}", test::own_domain()),
                                  fmt::format("simulation.duration={}", duration)};
  all.insert(all.end(), set.begin(), set.end());
  return read_scenario(SIGHTLINE_SOURCE_DIR "/fleets/localize.toml", with_links(), all);
}

TEST(LinkTelemetry, ACommandIsTheSameForTheRobotInAnyFrame) {
  // Its odometry is turned by 1 rad and began at (3, 0, 0) of G.
  const LinkOrigin frame = {{3, 0, 0}, 1.0};
  const Motion truth = {{1, 2, 1}, upright({0.6, 0.8}), {0.2, -0.1, 0.3}, 0.5};
  const LinkOrigin found = carried_frame(in_local(frame, truth), 0.0, truth);
  EXPECT_LT(norm(found.p - frame.p), 1e-12);
  EXPECT_NEAR(found.heading, 1.0, 1e-12);
  // A heading that is old turned on since.
  EXPECT_NEAR(carried_frame(in_local(frame, truth), 0.02, truth).heading, 1.0 - 0.01, 1e-12);
  Command command;
  command.lead.v = truth.v, command.lead.p = truth.p;
  command.d = command.lead.d = {0.6, 0.8};
  const Command local = in_local(frame, command);
  const Motion expected = in_local(frame, truth);
  EXPECT_LT(norm(local.lead.v - expected.v) + norm(local.lead.p - expected.p), 1e-12);
  const Vec2<double> d = heading(rotation(expected.q));
  EXPECT_NEAR(local.d.x, d.x, 1e-12);
  EXPECT_NEAR(local.lead.d.y, d.y, 1e-12);
}

TEST(LinkTelemetry, TheAttitudeFilterBehindALinkWithoutAnImuIsRefused) {
  Scenario scenario = localized(1.0, {by_attitude_filter});
  own_fleet(scenario).links[0].kind = Crazyswarm2Link{.name_space = "/cf0"};
  EXPECT_THAT(
      refusal_of([&] { DdsWorld world(scenario, std::make_shared<Domain>(fleet_of(scenario).network)); }),
      HasSubstr(
          "agent.uav0.estimate.filter = attitude, for which a link of kind crazyswarm2 has no "
          "accelerations, expected \"heading\", a link of kind px4, or one of kind crazyswarm2 with imu"));
}

TEST(LinkTelemetry, WithoutItsImuItStaysOnTheGround) {
  const Scenario scenario = localized(1.0, {by_attitude_filter});
  EXPECT_THAT(
      not_ready(scenario, std::make_shared<Domain>(fleet_of(scenario).network), 0.5),
      testing::Contains("uav0: rt/px4_1/fmu/out/sensor_combined: no measurement of its IMU, which the "
                        "attitude filter needs: it has no publisher"));
}

/// uav0 is a Crazyflie, whose log has its IMU in this order.
Scenario crazyflie_localized(double duration, std::vector<std::string> vars) {
  Scenario scenario = localized(duration, {by_attitude_filter});
  own_fleet(scenario).links[0].kind = Crazyswarm2Link{
      .name_space = "/cf0", .takeoff_height = 1.7, .imu = "/cf0/imu", .imu_vars = std::move(vars)};
  return scenario;
}

bool finds_words(const Rig& rig, std::string_view light, std::string_view words) {
  const std::vector<Finding> findings = rig.world->examine();
  return std::any_of(findings.begin(), findings.end(), [&](const Finding& finding) {
    return to_string(finding.light) == light && finding.sentence.find(words) != std::string::npos;
  });
}

/// uav0 keeps its distance to the body that it sees, for 3.5 s, by measurements of its IMU.
void expect_flies_by_its_imu(Rig& rig, const std::function<double()>& distance_now,
                             const std::string& counts) {
  double distance = -1.0;
  const LoopOutcome outcome = rig.fly(3.5, [&] { distance = distance_now(); });
  EXPECT_GE(outcome.updates + outcome.missed, 400) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_GT(distance, 1.2);
  EXPECT_LT(distance, 1.8);
  EXPECT_THAT(rig.counted("uav0: "),
              testing::ContainsRegex("[1-9][0-9]* measurements of its IMU, 0 not finite" + counts));
  EXPECT_THAT(rig.world->faults(), testing::IsEmpty());
}

// The simulated log has degrees and multiples of g; another order than that of the six is as good.
TEST(LinkTelemetry, ACrazyflieFliesByWhatItSeesAndTheLogOfItsImu) {
  const Scenario scenario =
      crazyflie_localized(4.0, {"acc.x", "acc.y", "acc.z", "pm.state", "gyro.z", "gyro.y", "gyro.x"});
  Rig rig(scenario);
  EXPECT_TRUE(
      test::eventually([&] { return finds_words(rig, "green", "measurements of its IMU a second"); }));
  expect_flies_by_its_imu(
      rig, [&] { return norm(rig.vehicle_simulators.of(0).motion().p - rig.vehicle(1).motion().p); },
      ", 0 with another");
}

TEST(LinkTelemetry, ALogWithoutTheVariablesOfTheFleetIsNoMeasurement) {
  const Scenario flown = crazyflie_localized(1.0, {crazyflie_imu.begin(), crazyflie_imu.end()});
  Scenario other =
      crazyflie_localized(1.0, {"gyro.x", "gyro.y", "gyro.z", "acc.x", "acc.y", "acc.z", "pm.state"});
  Rig rig(flown, other, {.ready = 1.0});
  EXPECT_TRUE(
      test::eventually([&] { return finds_words(rig, "red", "logs have not 6 values, as imu_vars has"); }));
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.counted("uav0: "), testing::ContainsRegex("[1-9][0-9]* with another number of values"));
}

// Its IMU is examined before, and no other robot's.
TEST(LinkTelemetry, ARobotFliesByWhatItSeesAndItsImu) {
  const Scenario scenario = localized(4.0, {by_attitude_filter});
  Rig rig(scenario);
  std::vector<std::string> rates;
  EXPECT_TRUE(test::eventually([&] {
    rates.clear();
    for (const Finding& finding : rig.world->examine())
      if (finding.sentence.find("measurements of its IMU a second") != std::string::npos)
        rates.push_back(fmt::format("{} {}", finding.robot, to_string(finding.light)));
    return rates == std::vector<std::string>{"uav0 green"};
  })) << fmt::format("{}", fmt::join(rates, "\n"));
  expect_flies_by_its_imu(
      rig, [&] { return norm(rig.vehicle(0).motion().p - rig.vehicle(1).motion().p); }, "");
  EXPECT_EQ(rig.counted("uav1: ").find("IMU"), std::string::npos);
  expect_well_treated(rig);
}

/// It keeps its distance to the body that it sees.
TEST(LinkTelemetry, ARobotFliesByWhatItSees) {
  const Scenario scenario = localized(4.0);
  Rig rig(scenario);
  // Others see how well it knows where it is, and by what camera.
  const dds_entity_t at = rig.domain->another_participant();
  std::atomic<int> estimates{0}, sure{0}, cameras{0};
  const Quality quality{.reliable = true, .depth = 100};
  RawReader of_estimates(
      at, geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc, "/sightline/uav0/estimate", quality,
      std::nullopt, Writers::all, [&](const void* reported, const Arrival&) {
        const auto& m = *static_cast<const geometry_msgs_msg_dds__PoseWithCovarianceStamped_*>(reported);
        ++estimates;
        const double variance = m.pose.covariance[0] + m.pose.covariance[7];
        if (variance > 0 && variance < 0.02 && m.pose.covariance[35] > 0) ++sure;
      });
  RawReader of_cameras(at, sensor_msgs_msg_dds__CameraInfo__desc, "/sightline/uav0/camera_info", quality,
                       std::nullopt, Writers::all, [&](const void* reported, const Arrival&) {
                         const auto& m = *static_cast<const sensor_msgs_msg_dds__CameraInfo_*>(reported);
                         if (m.width == 320 && m.k[0] > 200 && m.k[2] == 160.0) ++cameras;
                       });
  double distance = -1.0;
  const LoopOutcome outcome = rig.fly(3.5, [&] {
    // Both are where they are at about the same time.
    const Motion own = rig.vehicle(0).motion(), seen = rig.vehicle(1).motion();
    distance = norm(own.p - seen.p);
  });
  EXPECT_GE(outcome.updates + outcome.missed, 400) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  // Its attitude is in G, from which its odometry is turned by its heading at the start.
  const Vec2<double> ahead = heading(rotation(rig.last.attitudes[0]));
  EXPECT_NEAR(std::remainder(std::atan2(ahead.y, ahead.x) - rig.last.estimates[0].psi, 6.283185307), 0.0,
              0.02);
  EXPECT_GT(estimates, 50);
  EXPECT_GT(sure, 0.9 * estimates);
  EXPECT_GT(cameras, 3);
  EXPECT_GT(distance, 1.2);
  EXPECT_LT(distance, 1.8);
  EXPECT_THAT(rig.counted("pictures with tags"), HasSubstr("0 tags not finite or no poses, 0 of no body"));
  EXPECT_THAT(rig.world->faults(), testing::IsEmpty());
  expect_well_treated(rig);
}

// Its camera finds nothing any more: it does not know where it is any longer, and lands by its
// supervisor.
TEST(LinkTelemetry, ARobotThatSeesNothingAnyMoreLands) {
  const Scenario scenario =
      localized(12.0, {"safety.supervisor.sigma_hold=0.1", "safety.supervisor.sigma_land=0.15"});
  Rig rig(scenario);
  const LoopOutcome outcome = rig.fly(1.0, [&] { rig.faults(0).begin(Kind::blind); });
  EXPECT_TRUE(outcome.stopped);
  EXPECT_GT(outcome.updates, 120);
  EXPECT_LT(outcome.updates, 900);
  expect_well_treated(rig);
}

}  // namespace
}  // namespace sightline::dds
