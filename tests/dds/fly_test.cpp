/// The commands fly and vehicles as a person uses them: two programs, on loopback.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <regex>

#include "tests/dds/own_domain.hpp"
#include "tests/support/child.hpp"
#include "tests/support/command.hpp"

namespace sightline::dds {
namespace {

using test::Child;
using test::fresh_folder;
using test::read_file;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

class Fly : public testing::Test {
 protected:
  /// The shipped fleet, on a domain of its own, for so long [s].
  fs::path desk(const std::string& duration) const {
    std::string text = read_file(SIGHTLINE_SOURCE_DIR "/fleets/desk.toml");
    text = std::regex_replace(text, std::regex("\nduration = 60.0 "), "\nduration = " + duration + " ");
    text = std::regex_replace(text, std::regex("\ndomain = 77 "),
                              "\ndomain = " + std::to_string(test::own_domain()) + " ");
    std::ofstream(folder / "desk.toml") << text;
    return folder / "desk.toml";
  }
  /// The command with stdout and stderr in files of that name.
  std::unique_ptr<Child> begin(std::vector<std::string> words, const std::string& name) const {
    const std::string out = (folder / (name + ".out")).string(), err = (folder / (name + ".err")).string();
    return std::make_unique<Child>(std::move(words), [out, err] {
      if (std::freopen(out.c_str(), "w", stdout) == nullptr ||
          std::freopen(err.c_str(), "w", stderr) == nullptr)
        ::_exit(125);
    });
  }
  std::string said(const std::string& name) const { return read_file(folder / name); }
  bool says(const std::string& name, const std::string& what) const {
    return test::eventually([&] { return said(name).find(what) != std::string::npos; },
                            std::chrono::seconds(20));
  }
  void expect_replayed(const std::string& flight) const {
    const auto done = test::sightline("replay " + (folder / flight).string(), folder);
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_THAT(done.out, HasSubstr(" commands, 0 differ"));
  }
  std::vector<std::string> flight(const fs::path& fleet) const {
    return {"fly", fleet.string(), "-o", (folder / "flown").string()};
  }

  fs::path folder = fresh_folder();
};

TEST_F(Fly, TheShippedFleetTakesOffFliesItsTaskLandsAndIsReplayed) {
  const fs::path fleet = desk("10.0");
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
  EXPECT_THAT(said("vehicles.out"), HasSubstr("(0 outside offboard, 0 bad)"));
  EXPECT_THAT(said("vehicles.out"), HasSubstr("1 requests to arm, 1 for offboard, disarmed"));
  EXPECT_THAT(said("vehicles.out"), Not(HasSubstr("failsafe")));
  expect_replayed("flown");
}

TEST_F(Fly, CtrlCLandsAllAndTheFlightIsReplayed) {
  const fs::path fleet = desk("60.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto flyer = begin(flight(fleet), "fly");
  ASSERT_TRUE(says("fly.err", "uav1: holding"));
  std::this_thread::sleep_for(std::chrono::seconds(3));
  ::kill(flyer->pid(), SIGINT);
  EXPECT_TRUE(test::eventually([&] { return flyer->ended(); }, std::chrono::seconds(20)));
  EXPECT_EQ(flyer->code(), 0) << said("fly.err");
  EXPECT_THAT(said("fly.err"), HasSubstr("uav0: done"));
  vehicles->end(SIGINT);
  EXPECT_THAT(said("vehicles.out"), HasSubstr("disarmed"));
  EXPECT_THAT(said("vehicles.out"), Not(HasSubstr(", armed")));
  expect_replayed("flown");
}

TEST_F(Fly, VehiclesThatAreKilledAreGivenUpAndTheFlightIsReplayed) {
  const fs::path fleet = desk("60.0");
  auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto flyer = begin(flight(fleet), "fly");
  ASSERT_TRUE(says("fly.err", "uav1: holding"));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  vehicles->end(SIGKILL);
  EXPECT_TRUE(says("fly.err", "uav0: landing, nothing came from it any more"));
  ::kill(flyer->pid(), SIGINT);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // two at a time are one
  ::kill(flyer->pid(), SIGINT);  // a second one leaves them to their autopilots
  EXPECT_TRUE(test::eventually([&] { return flyer->ended(); }, std::chrono::seconds(10)));
  EXPECT_EQ(flyer->code(), 1);
  expect_replayed("flown");
}

TEST_F(Fly, VehiclesThatRestartInFlightAreNeitherArmedNorSteeredAgain) {
  const fs::path fleet = desk("60.0");
  auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto flyer = begin(flight(fleet), "fly");
  ASSERT_TRUE(says("fly.err", "uav1: holding"));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  vehicles->end(SIGKILL);
  const auto again = begin({"vehicles", fleet.string()}, "again");
  EXPECT_TRUE(test::eventually([&] { return flyer->ended(); }, std::chrono::seconds(20)));
  EXPECT_EQ(flyer->code(), 1);
  EXPECT_THAT(said("fly.err"), HasSubstr("it was disarmed"));
  again->end(SIGINT);
  for (const char* uav : {"uav0", "uav1"})
    EXPECT_THAT(said("again.out"),
                testing::ContainsRegex(std::string(uav) +
                                       ": 0 set-points .* 0 requests to arm, 0 for offboard, disarmed"));
  expect_replayed("flown");
}

TEST_F(Fly, ADryRunArmsNothingAndIsNoFailure) {
  const fs::path fleet = desk("10.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto dry =
      test::sightline("fly --dry-run " + fleet.string() + " -o " + (folder / "flown").string(), folder);
  EXPECT_EQ(dry.code, 0) << dry.err;
  EXPECT_THAT(dry.err, HasSubstr("all are ready, none is armed: a dry run"));
  vehicles->end(SIGINT);
  EXPECT_THAT(said("vehicles.out"), HasSubstr(" 0 requests to arm"));
  EXPECT_THAT(said("vehicles.out"), Not(HasSubstr(" 1 requests to arm")));
}

TEST_F(Fly, AFlyerThatIsKilledLeavesALogThatIsReplayedAndVehiclesThatFailSafe) {
  const fs::path fleet = desk("60.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto flyer = begin(flight(fleet), "fly");
  ASSERT_TRUE(says("fly.err", "uav1: holding"));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  flyer->end(SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  vehicles->end(SIGINT);
  EXPECT_TRUE(
      std::regex_search(said("vehicles.out"), std::regex("failsafe 1\\.0[0-9]* s after the last heartbeat")))
      << said("vehicles.out");
  expect_replayed("flown");
}

TEST_F(Fly, WhereNobodyAnswersItSaysWhoIsMissingAndArmsNothing) {
  const auto flown =
      test::sightline("fly " + desk("10.0").string() + " -o " + (folder / "flown").string(), folder);
  EXPECT_EQ(flown.code, 1);
  EXPECT_THAT(flown.err, HasSubstr("uav0: done, it was not ready in time"));
  EXPECT_THAT(flown.err, HasSubstr("uav1: rt/px4_2/fmu/out/vehicle_odometry: no message of PX4 1.16"));
  EXPECT_THAT(flown.err, Not(HasSubstr("arming")));
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
