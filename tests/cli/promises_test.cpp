// Inputs that once broke a promise of the README: what comes out of the command line for each.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "tests/support/child.hpp"
#include "tests/support/command.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::fresh_folder;
using test::refused;
using test::sightline;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

constexpr const char* shipped = "scenarios/cooperative_localization.toml";

std::string promise(const std::string& name) { return "tests/scenarios/promises/" + name + ".toml"; }

struct Flown {
  test::CommandResult run;
  json summary;
  fs::path out;
};

Flown flown(const std::string& arguments) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  Flown of{sightline("run " + arguments + " -o " + out.string(), folder), {}, out};
  if (fs::exists(out / "summary.json")) of.summary = json::parse(test::read_file(out / "summary.json"));
  return of;
}

double least_hard_distance(const json& summary) {
  double least = 1e9;
  for (const json& pair : summary.at("safety").at("hard_distances"))
    least = std::min(least, pair.at("least").get<double>());
  return least;
}

const json& wall(const json& summary, const std::string& kind) {
  for (const json& one : summary.at("safety").at("walls"))
    if (one.at("wall") == kind) return one;
  throw std::runtime_error("no wall " + kind);
}

TEST(Promises, AMeasurementThatIsNoNumberReachesNoCommand) {
  const Flown of = flown(promise("nan_command"));
  EXPECT_EQ(of.run.code, 0) << of.run.err;
  EXPECT_EQ(of.summary.at("applied_violations"), 0);
  const auto again = sightline("replay " + of.out.string(), of.out.parent_path());
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("0 differ"));
}

TEST(Promises, LimitsThatNarrowAreObeyedAtOnceWhateverTheRateLimit) {
  const Flown of = flown(promise("rate_retune"));
  EXPECT_EQ(of.run.code, 0) << of.run.err;
  EXPECT_EQ(of.summary.at("applied_violations"), 0);
}

TEST(Promises, AFloorIsJudgedWhateverMovesTheRobot) {
  const Flown of = flown(promise("plane_floor"));
  EXPECT_EQ(of.run.code, 1);
  EXPECT_FALSE(wall(of.summary, "floor").at("kept"));
  EXPECT_NEAR(wall(of.summary, "floor").at("worst").get<double>(), -5.03, 0.05);
  EXPECT_THAT(of.run.out, ContainsRegex("floor +plane: -5.* BROKEN"));
}

TEST(Promises, RobotsThatPassThroughEachOtherBetweenTwoSamplesAreFound) {
  const Flown of = flown(promise("between"));
  EXPECT_EQ(of.run.code, 1);
  EXPECT_LT(least_hard_distance(of.summary), 1e-3);
}

TEST(Promises, TheStateAfterTheLastCommandIsJudged) {
  const Flown of = flown(promise("last_period"));
  EXPECT_EQ(of.run.code, 1);
  EXPECT_NEAR(least_hard_distance(of.summary), 0.4, 1e-3);
}

TEST(Promises, PeriodsThatAStoppedProcessMissedAreJudged) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  test::Child flight({"run", promise("missed"), "--realtime", "-o", out},
                     [] { (void)!std::freopen("/dev/null", "w", stdout); });
  ASSERT_TRUE(test::eventually([&] { return fs::exists(out / "run.mcap"); }));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  ::kill(flight.pid(), SIGSTOP);
  std::this_thread::sleep_for(std::chrono::seconds(5));
  ::kill(flight.pid(), SIGCONT);
  ASSERT_TRUE(test::eventually([&] { return flight.ended(); }));
  EXPECT_EQ(flight.code(), 1);
  EXPECT_LT(least_hard_distance(json::parse(test::read_file(out / "summary.json"))), 0.1);
}

TEST(Promises, TheHardDistanceIsKeptAtLongPeriods) {
  const fs::path folder = fresh_folder();
  for (const auto& [name, chosen] : {std::pair{"period_025_guarantee", "--seed 1 --only 110"},
                                     {"period_020_guarantee", "--seed 5 --only 52"}}) {
    const fs::path out = folder / name;
    const auto run = sightline("campaign " + promise(name) + " " + chosen + " -o " + out.string(), folder);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_GE(least_hard_distance(json::parse(test::read_file(out / "summary.json"))), 1.0) << name;
  }
}

TEST(Promises, ThePresetOfTheArDroneIsAcceptedWhereItsVelocityStaysInItsFrame) {
  const fs::path folder = fresh_folder();
  EXPECT_THAT(refused("check " + promise("ar_drone_barrier"), folder),
              AllOf(HasSubstr("turns with its heading"), HasSubstr("expected a lower yaw rate")));
  std::string set;
  for (const char* robot : {"a", "b"}) {
    for (const char* key : {"frame=\"level\"", "tau_psi=0.0", "yaw_max=0.5"})
      set += std::string(" --set 'agent.") + robot + ".parameters." + key + "'";
  }
  const auto accepted = sightline("check " + promise("ar_drone_barrier") + set, folder);
  EXPECT_EQ(accepted.code, 0) << accepted.err;
}

TEST(Promises, AStartBeyondAWallIsBrokenUnlessTheScenarioMeansIt) {
  const std::string below = std::string(shipped) +
                            " --set 'agent.uav0.start.p=[-1.2,0.0,-1.2]' --set simulation.duration=10.0",
                    above = std::string(shipped) +
                            " --set safety.ceiling=2.5 --set 'agent.uav0.start.p=[-1.2,0.0,4.0]' --set "
                            "simulation.duration=10.0";
  for (const auto& [arguments, kind] : {std::pair{below, "floor"}, {above, "ceiling"}}) {
    const Flown of = flown(arguments);
    EXPECT_EQ(of.run.code, 1) << kind;
    EXPECT_FALSE(wall(of.summary, kind).at("kept"));
    EXPECT_NEAR(wall(of.summary, kind).at("broken_for").get<double>(), 1.5, 0.3) << kind;
    const Flown meant = flown(arguments + " --set safety.start_outside=true");
    EXPECT_EQ(meant.run.code, 0) << meant.run.err;
    EXPECT_THAT(meant.run.out,
                ContainsRegex(std::string(kind) + " .*outside at the start for 1\\.[0-9]+ s, then kept"));
  }
}

TEST(Promises, AHalfTurnIsTurned) {
  const Flown of = flown(promise("half_turn"));
  EXPECT_EQ(of.run.code, 0) << of.run.err;
  // 3 s of a turn at 1.6 rad/s, 1 s of it after 150 degrees: on the mean less than 1.2 rad.
  EXPECT_LT(of.summary.at("agents").at(0).at("rms_heading_error").get<double>(), 0.1);
}

TEST(Promises, AKeyThatNothingTakesUpIsNamed) {
  const Flown of = flown(promise("boat"));
  EXPECT_EQ(of.run.code, 0) << of.run.err;
  EXPECT_THAT(of.run.err, HasSubstr("warning: simulation.disturbance.wind has no effect"));
}

TEST(Promises, AFixedWingAsTextStartsWithItsSpeedAndKeepsALeastOne) {
  const fs::path folder = fresh_folder();
  EXPECT_THAT(refused("check " + promise("fixed_wing"), folder),
              HasSubstr("start.state gives every state of a robot"));
  const Flown of =
      flown(promise("fixed_wing") + " --set 'agent.plane.start={state=[0.0,-60.0,40.0,0.0,12.0]}'");
  EXPECT_EQ(of.run.code, 0) << of.run.err;
  const Flown slow = flown(promise("fixed_wing_least_speed"));
  EXPECT_EQ(slow.run.code, 0) << slow.run.err;
}

TEST(Promises, ACameraMayLookAnywhereAndASensorSeeBehindItself) {
  const fs::path folder = fresh_folder();
  for (const char* set :
       {"agent.uav0.sensor.pitch=1.5707963267948966", "agent.uav0.sensor.pitch=-1.5708",
        "agent.uav0.sensor.yaw=1.57", "agent.uav0.sensor.roll=0.1",
        "agent.uav0.sensor.offset=[0.1,-0.2,0.05]", "couple[0].potential.bearing.alpha=1.66",
        "couple[0].potential.bearing.alpha=3.14159"}) {
    const auto run = sightline(fmt::format("check {} --set '{}'", shipped, set), folder);
    EXPECT_EQ(run.code, 0) << set << run.err;
  }
}

TEST(Promises, WhatAMountCannotSayIsRefusedWithWhatItCan) {
  const fs::path folder = fresh_folder();
  EXPECT_THAT(refused(std::string("check ") + shipped + " --set agent.uav0.sensor.quaternion=1", folder),
              AllOf(HasSubstr("expected a known key: frame, yaw, pitch, roll, offset, sigmas"),
                    Not(HasSubstr("nearest"))));
}

TEST(Promises, CommandsThatActLateAreJudgedByTheMotionThatTheyMake) {
  const Flown low = flown(promise("delay_multi"));
  EXPECT_EQ(low.run.code, 1);
  EXPECT_THAT(low.run.err, HasSubstr("floor"));
  EXPECT_NEAR(wall(low.summary, "floor").at("worst").get<double>(), 1.40, 1e-3);
  const Flown near = flown(promise("delay_pair"));
  EXPECT_EQ(near.run.code, 1);
  EXPECT_NEAR(least_hard_distance(near.summary), 1.00, 1e-3);
  const Flown high = flown(promise("delay_false"));
  EXPECT_EQ(high.run.code, 0) << high.run.err;
}

// Of a robot of another model the speed that its model reaches is assumed.
TEST(Promises, RobotsOfUnequalStrengthOrSpeedKeepTheirDistance) {
  for (const char* name : {"hetero_text", "text_limits", "hetero_uncoop_speed"}) {
    const Flown of = flown(promise(name));
    EXPECT_EQ(of.run.code, 0) << name << ": " << of.run.err;
    EXPECT_GE(least_hard_distance(of.summary), 0.6) << name;
  }
}

TEST(Promises, WhereRobotsClimbLateTheLackOfAGuaranteeIsSaid) {
  const test::CommandResult checked = sightline("check " + promise("px4_pair"), fresh_folder());
  EXPECT_EQ(checked.code, 0) << checked.err;
  EXPECT_THAT(checked.out + checked.err, HasSubstr("a climbs late, so that no other robot counts on it"));
}

TEST(Promises, CheckRefusesLimitsToComeThatABarrierCannotKeep) {
  EXPECT_THAT(refused("check " + promise("limits_to_come"), fresh_folder()),
              ContainsRegex("limits_to_come\\.toml:[0-9]+: safety: "));
}

}  // namespace
}  // namespace sightline
