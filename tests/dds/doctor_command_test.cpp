/// The command doctor as a person uses it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "bridges/dds/fleet/finding.hpp"
#include "tests/dds/fly.hpp"

namespace sightline::dds {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

using DoctorCommand = FlyTest;

TEST_F(DoctorCommand, ALightForEachAspectOfEachRobotAndAnExitCode) {
  const fs::path fleet = desk("10.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  ASSERT_TRUE(prints("vehicles.err", "simulated vehicles"));
  const auto seen = test::sightline("doctor --json --seconds 3 " + fleet.string(), folder);
  const auto json = nlohmann::json::parse(seen.out);
  EXPECT_EQ(json["fleet"], "desk");
  EXPECT_EQ(json["seconds"], 3.0);
  std::set<std::string> aspects_seen;
  for (const auto& finding : json["findings"]) {
    aspects_seen.insert(finding["aspect"]);
    if (finding["aspect"] == "timing") continue;  // of a machine that does other things as well
    EXPECT_EQ(finding["light"], "green") << finding;
    EXPECT_FALSE(finding["sentence"].get<std::string>().empty());
  }
  EXPECT_EQ(aspects_seen.size(), 16u) << seen.out;  // no satellite and no camera
  EXPECT_EQ(seen.code, json["light"] == "green" ? 0 : 1);
  EXPECT_EQ(json["poses"][0]["robot"], "uav0");
  EXPECT_NEAR(json["poses"][0]["p"][0], -1.2, 0.05);
  EXPECT_NEAR(json["timing"]["periods"].get<double>(), 300, 3);
  EXPECT_EQ(json["timing"]["period"], 0.01);

  const auto watched = test::sightline("doctor --watch --seconds 2 " + fleet.string(), folder);
  EXPECT_EQ(watched.code, 0) << watched.err;
  EXPECT_THAT(watched.out, HasSubstr("moved since the start [m]"));
  EXPECT_THAT(watched.out,
              testing::ContainsRegex("uav0 +\\[ +-1\\.20, +-?0\\.00, +-?0\\.00\\] +\\[ +-?0\\.00,"));
  EXPECT_EQ(test::lines(watched.out), 5);
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"),
              HasSubstr("0 set-points (0 outside offboard, 0 bad), 0 heartbeats, 0 requests to arm"));
}

TEST_F(DoctorCommand, WhereNobodyIsThereItIsRedWithinItsTime) {
  const auto begun = std::chrono::steady_clock::now();
  const auto seen = test::sightline("doctor --seconds 2 " + desk("10.0").string(), folder);
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(6));
  EXPECT_EQ(seen.code, 1);
  EXPECT_THAT(seen.out, HasSubstr("uav1\n  red      topics     rt/px4_2/fmu/out/vehicle_odometry: no message "
                                  "of PX4 1.16, it has no publisher\n"));
  EXPECT_THAT(seen.out, HasSubstr("this machine\n"));
  EXPECT_THAT(seen.out, HasSubstr(": sightline fly refuses this fleet\n"));
  EXPECT_THAT(seen.out, Not(HasSubstr("\033[")));
}

TEST_F(DoctorCommand, WhatIsNoFleetIsRefused) {
  const auto refused = test::sightline("doctor scenarios/cooperative_localization.toml", folder);
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("fleet is missing"));
  EXPECT_EQ(test::sightline("doctor fleets/desk.toml --seconds 0", folder).code, 2);
  EXPECT_EQ(test::sightline("doctor fleets/desk.toml --set fleet.interfaces='[\"nowhere0\"]'", folder).code,
            2);
}

}  // namespace
}  // namespace sightline::dds
