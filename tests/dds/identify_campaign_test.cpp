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

// The stand-in follows climbs with a lag of 0.3 s and yaw rates with one of 0.1 s, as they are asked for. A push forward comes through
// its lag of 0.3 s and the acceleration that is fed forward: 1 + 0.05 / 0.3 of what the model asks, less for what is late.
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
  EXPECT_THAT(said("vehicles.out"), HasSubstr("(0 outside offboard, 0 bad)"));
  EXPECT_THAT(said("vehicles.out"), HasSubstr("1 requests to arm, 1 for offboard, disarmed"));
  EXPECT_THAT(said("vehicles.out"), HasSubstr("uav1: 0 set-points"));
  const auto json = nlohmann::json::parse(done.out);
  const auto number = [&](const std::string& key) {
    for (const auto& one : json["best"]["numbers"])
      if (one["key"] == key) return one;
    ADD_FAILURE() << key << " was not found: " << done.out;
    return nlohmann::json();
  };
  const auto expect_near = [&](const std::string& key, double truth, double by) {
    const auto one = number(key);
    if (one.is_null()) return;
    EXPECT_NEAR(one["value"].get<double>(), truth, by) << one;
  };
  // Its steps of 0.01 s are those of lags of 0.295 s and 0.095 s. How its periods lie between ours is not known, and moves the lags.
  expect_near("tau_z", 0.295, 0.03);
  expect_near("tau_psi", 0.095, 0.02);
  expect_near("b_z", 1.0, 0.05);
  expect_near("b_psi", 1.6, 0.05);
  for (const char* key : {"b_f", "b_s"}) expect_near(key, 1.62, 0.2);
}

TEST_F(IdentifyOverLink, WhereThereIsNoRoomItIsToldAndTheRobotLands) {
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
  EXPECT_THAT(said("vehicles.out"), HasSubstr("1 requests to arm, 1 for offboard, disarmed"));
}

}  // namespace
}  // namespace sightline::dds
