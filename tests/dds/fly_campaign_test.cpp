/// Programs that are interrupted or killed in flight.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/dds/fly.hpp"
#include "tests/support/campaign.hpp"

namespace sightline::dds {
namespace {

using testing::HasSubstr;
using testing::Not;

using FlyInterrupted = FlyTest;

TEST_F(FlyInterrupted, CtrlCLandsAllAndTheFlightIsReplayed) {
  const Flying one = in_task("desk", std::chrono::seconds(1));
  ::kill(one.flyer->pid(), SIGINT);
  EXPECT_TRUE(test::eventually([&] { return one.flyer->ended(); }, std::chrono::seconds(20)));
  EXPECT_EQ(one.flyer->code(), 0) << printed("fly.err");
  EXPECT_THAT(printed("fly.err"), HasSubstr("uav0: done"));
  one.vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), HasSubstr("disarmed"));
  EXPECT_THAT(printed("vehicles.out"), Not(HasSubstr(", armed")));
  expect_replayed("flown");
}

TEST_F(FlyInterrupted, VehiclesThatAreKilledAreGivenUpAndTheFlightIsReplayed) {
  const Flying one = in_task("desk", std::chrono::milliseconds(700));
  one.vehicles->end(SIGKILL);
  // Whose last message is older is given up first; then all land.
  EXPECT_TRUE(prints("fly.err", ": landing, nothing came from it any more")) << printed("fly.err");
  ::kill(one.flyer->pid(), SIGINT);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // two at a time are one
  ::kill(one.flyer->pid(), SIGINT);  // a second one leaves them to their autopilots
  EXPECT_TRUE(test::eventually([&] { return one.flyer->ended(); }, std::chrono::seconds(10)));
  EXPECT_EQ(one.flyer->code(), 1);
  expect_replayed("flown");
}

TEST_F(FlyInterrupted, AFlyerThatIsKilledLeavesALogThatIsReplayedAndVehiclesThatFailSafe) {
  const Flying one = in_task("desk", std::chrono::milliseconds(700));
  one.flyer->end(SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  one.vehicles->end(SIGINT);
  EXPECT_TRUE(std::regex_search(printed("vehicles.out"),
                                std::regex("failsafe 1\\.0[0-9]* s after the last heartbeat")))
      << printed("vehicles.out");
  expect_replayed("flown");
}

TEST_F(FlyInterrupted, WhereNobodyAnswersItSaysWhoIsMissingAndArmsNothing) {
  const auto flown =
      test::sightline("fly " + desk("10.0").string() + " -o " + (folder / "flown").string(), folder);
  EXPECT_EQ(flown.code, 1);
  EXPECT_THAT(flown.err, HasSubstr("uav0: done, it was not ready in time"));
  EXPECT_THAT(flown.err, HasSubstr("uav1: rt/px4_2/fmu/out/vehicle_odometry: no message of PX4 1.16"));
  EXPECT_THAT(flown.err, Not(HasSubstr("arming")));
}

using FlyWhole = FlyTest;
const std::string task = whole_campaign() ? "60.0" : "2.0";  // [s]

TEST_F(FlyWhole, TwoCrazyfliesFly) { expect_flies("crazyflies", task); }
TEST_F(FlyWhole, AMultirotorWatchesARoverOnRos2) { expect_flies("rover", task); }

TEST_F(FlyInterrupted, CrazyfliesWhoseFlyerIsKilledLevelOutAndStopTheirMotors) {
  const Flying one = in_task("crazyflies", std::chrono::milliseconds(700));
  one.flyer->end(SIGKILL);
  std::this_thread::sleep_for(std::chrono::milliseconds(2500));
  one.vehicles->end(SIGINT);
  EXPECT_TRUE(std::regex_search(
      printed("vehicles.out"),
      std::regex("locked, .*levelled out 0\\.5[0-9]* s after the last set-point, motors off 2\\.0[0-9]* s")))
      << printed("vehicles.out");
  expect_replayed("flown");
}

}  // namespace
}  // namespace sightline::dds
