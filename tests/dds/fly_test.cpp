#include "tests/dds/fly.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "tests/support/campaign.hpp"

namespace sightline::dds {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

using Fly = FlyTest;

TEST_F(Fly, TheShippedFleetTakesOffFliesItsTaskLandsAndIsReplayed) {
  const fs::path fleet = desk("4.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto flown = test::sightline("fly " + fleet.string() + " -o " + (folder / "flown").string(), folder);
  EXPECT_EQ(flown.code, 0) << flown.out << flown.err;
  EXPECT_THAT(flown.out, HasSubstr("report.html"));
  EXPECT_THAT(flown.out, HasSubstr("allocations in an update  0\n"));
  for (const char* state :
       {"uav0: ready", "uav1: arming", "uav0: taking_off", "uav1: holding", "uav0: landing", "uav1: done"})
    EXPECT_THAT(flown.err, HasSubstr(state));
  vehicles->end(SIGINT);
  EXPECT_EQ(vehicles->code(), 0);
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("(0 outside offboard, 0 bad)"));
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("1 requests to arm, 1 for offboard, disarmed"));
  EXPECT_THAT(printed("vehicles.out"), Not(HasSubstr("failsafe")));
  expect_replayed("flown");
}

TEST_F(Fly, AMixedFleetFliesOneTask) { expect_flies("mixed", whole_campaign() ? "60.0" : "2.0"); }

TEST_F(Fly, ARobotWithoutAPositionFliesByWhatItSees) {
  expect_flies("localize", whole_campaign() ? "60.0" : "3.0");
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("pictures with tags: "));
}

// The log has each motion sample with the means of its IMU: the estimates of a replay are the same
// bits.
TEST_F(Fly, ARobotWithTheAttitudeFilterFliesByItsImuAndIsReplayed) {
  expect_flies("localize", whole_campaign() ? "60.0" : "3.0",
               " --set 'agent.uav0.estimate.filter=\"attitude\"'");
  const auto replayed = test::sightline("replay " + (folder / "flown").string(), folder);
  EXPECT_THAT(replayed.out, testing::ContainsRegex("[1-9][0-9]* estimates of poses, 0 differ"));
}

TEST_F(Fly, ACrazyflieWithTheAttitudeFilterFliesByTheLogOfItsImuAndIsReplayed) {
  const fs::path fleet = fleet_of("localize", whole_campaign() ? "60.0" : "3.0");
  const std::string text = std::regex_replace(
      test::read_file(fleet),
      std::regex("kind = \"px4\"\nrelease = .*\nnamespace = \"/px4_1\".*\ntarget_system = 2.*\n"),
      "kind = \"crazyswarm2\"\nimu = \"/uav0/imu\"\ntakeoff_height = 1.7\n");
  std::ofstream(fleet) << text;
  expect_file_flies(fleet, " --set 'agent.uav0.estimate.filter=\"attitude\"'");
  const auto replayed = test::sightline("replay " + (folder / "flown").string(), folder);
  EXPECT_THAT(replayed.out, testing::ContainsRegex("[1-9][0-9]* estimates of poses, 0 differ"));
}

// As `sightline check` does.
TEST_F(Fly, EachShippedFleetIsRead) {
  for (const auto& file : fs::directory_iterator(SIGHTLINE_SOURCE_DIR "/fleets")) {
    const auto checked = test::sightline("check " + file.path().string(), folder);
    EXPECT_EQ(checked.code, 0) << checked.err;
    EXPECT_THAT(checked.out, HasSubstr("link        "));
  }
}

TEST_F(Fly, VehiclesThatRestartInFlightAreNeitherArmedNorSteeredAgain) {
  const Flying one = in_task("desk", std::chrono::milliseconds(500));
  one.vehicles->end(SIGKILL);
  const auto again = begin({"vehicles", one.fleet.string()}, "again");
  EXPECT_TRUE(test::eventually([&] { return one.flyer->ended(); }, std::chrono::seconds(20)));
  EXPECT_EQ(one.flyer->code(), 1);
  EXPECT_THAT(printed("fly.err"),
              testing::AnyOf(HasSubstr("it was restarted"), HasSubstr("it was disarmed")));
  again->end(SIGINT);
  // A few set-points may have left before its first word was heard; an autopilot outside offboard
  // drops them.
  for (const char* uav : {"uav0", "uav1"})
    EXPECT_THAT(printed("again.out"),
                testing::ContainsRegex(std::string(uav) +
                                       ": [0-9] set-points .* 0 requests to arm, 0 for offboard, disarmed"));
  expect_replayed("flown");
}

TEST_F(Fly, ADryRunArmsNothingAndIsNoFailure) {
  const fs::path fleet = desk("10.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const fs::path flown = folder / "flown";
  const auto dry = test::sightline("fly --dry-run " + fleet.string() + " -o " + flown.string(), folder);
  EXPECT_EQ(dry.code, 0) << dry.err;
  EXPECT_THAT(dry.err, HasSubstr("all are ready, none is armed: a dry run"));
  EXPECT_FALSE(fs::exists(flown)) << "a folder keeps the flight that it has";
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), HasSubstr(" 0 requests to arm"));
  EXPECT_THAT(printed("vehicles.out"), Not(HasSubstr(" 1 requests to arm")));
}

// stdin of the stand-ins is a terminal, at which somebody types.
TEST_F(Fly, FaultsBeginAndEndByKey) {
  const fs::path fleet = desk("10.0");
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(terminal, 0);
  ASSERT_EQ(::grantpt(terminal) + ::unlockpt(terminal), 0);
  const std::string err = (folder / "vehicles.err").string(), name = ::ptsname(terminal);
  test::Child vehicles({"vehicles", fleet.string()}, [&] {
    (void)::setsid();  // the terminal becomes its own
    const int its = ::open(name.c_str(), O_RDWR);
    if (its < 0 || ::dup2(its, STDIN_FILENO) < 0 || std::freopen(err.c_str(), "w", stderr) == nullptr ||
        std::freopen("/dev/null", "w", stdout) == nullptr)
      ::_exit(125);
  });
  ASSERT_TRUE(prints("vehicles.err", "faults by key")) << printed("vehicles.err");
  const auto type = [&](std::string_view keys) {
    EXPECT_EQ(::write(terminal, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  };
  type("2d");
  EXPECT_TRUE(prints("vehicles.err", "uav1: drop 0.2 begins")) << printed("vehicles.err");
  type("d1w");
  EXPECT_TRUE(prints("vehicles.err", "uav1: drop ends"));
  EXPECT_TRUE(prints("vehicles.err", "uav0: wrong_release 0 begins"));
  vehicles.end(SIGINT);
  EXPECT_EQ(vehicles.code(), 0);
  ::close(terminal);
}

TEST_F(Fly, WhereItWaitsForACallNothingIsArmedBefore) {
  const fs::path fleet = desk("10.0"), log = folder / "flown/run.mcap";
  fs::create_directories(log.parent_path());
  std::ofstream(log) << "of an earlier flight";
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  std::vector<std::string> words = flight(fleet);
  words.emplace_back("--wait");
  const auto flyer = begin(words, "fly");
  ASSERT_TRUE(prints("fly.err", "all are ready: /sightline/start lets them take off")) << printed("fly.err");
  flyer->end(SIGINT);
  EXPECT_EQ(flyer->code(), 0) << printed("fly.err");
  EXPECT_EQ(printed("flown/run.mcap"), "of an earlier flight") << "a folder keeps the flight that it has";
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), HasSubstr(" 0 requests to arm"));
  EXPECT_THAT(printed("vehicles.out"), Not(HasSubstr(" 1 requests to arm")));
  EXPECT_NE(test::sightline("fly --wait --dry-run " + fleet.string(), folder).code, 0);
}

TEST_F(Fly, AScenarioWithoutAFleetIsRefused) {
  for (const char* command : {"fly", "vehicles"}) {
    const auto refused =
        test::sightline(std::string(command) + " scenarios/cooperative_localization.toml", folder);
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.err,
                HasSubstr("cooperative_localization.toml:1: fleet is missing, expected a [fleet]"));
  }
}

}  // namespace
}  // namespace sightline::dds
