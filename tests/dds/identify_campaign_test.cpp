/// The command identify over a link, as a person uses it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/dds/fly.hpp"

namespace sightline::dds {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

using IdentifyOverLink = FlyTest;

// The stand-in follows climbs with a lag of 0.3 s and yaw rates with one of 0.1 s, as commanded.
// Forward and sideways it holds the trajectory of the model that is flown, which is found again.
// How its periods lie between ours is the delay that is found.
TEST_F(IdentifyOverLink, FindsTheNumbersOfTheStandIn) {
  const fs::path fleet = desk("10.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto done = test::sightline("identify " + fleet.string() + " --agent uav0 --seconds 20 --json -o " +
                                        (folder / "identified").string(),
                                    folder);
  ASSERT_EQ(done.code, 0) << done.err;
  vehicles->end(SIGINT);
  // It took off, landed, and left the other one on the ground.
  EXPECT_THAT(done.err, HasSubstr("uav0: done"));
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("(0 outside offboard, 0 bad)"));
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("1 requests to arm, 1 for offboard, disarmed"));
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("uav1: 0 set-points"));
  const auto json = nlohmann::json::parse(done.out);
  const auto number = [&](const std::string& key) {
    for (const auto& one : json["best"]["numbers"])
      if (one["key"] == key) return one;
    ADD_FAILURE() << key << " was not found: " << done.out;
    return nlohmann::json();
  };
  const auto expect_known = [&](const std::string& key, double truth) {
    const auto one = number(key);
    if (one.is_null()) return;
    constexpr double slack = 1e-3;  // beside the interval: of 1 ms, or of 0.001
    EXPECT_LE(one["low"].get<double>() - slack, truth) << one;
    EXPECT_GE(one["high"].get<double>() + slack, truth) << one;
  };
  expect_known("tau_z", 0.3);
  expect_known("tau_psi", 0.1);
  expect_known("b_z", 1.0);
  expect_known("b_psi", 1.6);
  for (const char* key : {"b_f", "b_s"}) {
    const auto one = number(key);
    if (!one.is_null()) {
      EXPECT_NEAR(one["value"].get<double>(), 1.458, 0.15) << one;
    }
  }
  const auto delay = number("delay");
  EXPECT_GE(delay["value"].get<double>(), 0.0);
  EXPECT_LE(delay["value"].get<double>(), 0.02);
}

TEST_F(IdentifyOverLink, WhereThereIsNoRoomItIsReportedAndTheRobotLands) {
  const fs::path fleet = desk("10.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto done =
      test::sightline("identify " + fleet.string() + " --agent uav0 --set safety.ceiling=1.1", folder);
  EXPECT_EQ(done.code, 2);
  EXPECT_THAT(done.err, HasSubstr("expected room of 0.75 m level and 0.3"));
  EXPECT_THAT(done.err, HasSubstr("uav0: done"));
  const auto high = test::sightline("identify " + fleet.string() + " --agent uav0 --height 3", folder);
  EXPECT_EQ(high.code, 2);
  EXPECT_THAT(high.err, HasSubstr("--height of a robot on a link, expected none"));
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("1 requests to arm, 1 for offboard, disarmed"));
}

}  // namespace
}  // namespace sightline::dds
