/// Flights that end in every way, and over bad links.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "tests/dds/rig.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

// Commands go to the vehicle in its own frame, and come back as measurements in G: a wrong sign
// anywhere would lead away.
TEST(DdsFlights, AVehicleWithRotorsFollowsItsReference) {
  Rig rig(row_of({"1.16"}, 6.0, "[agent.uav0.vehicle]\npreset = \"x500\"\n", "rotors"));
  std::vector<double> error;
  const LoopOutcome outcome = rig.fly(5.5, [&] {
    const Motion m = rig.vehicle(0).motion();
    error.push_back(std::abs(norm(m.p.x, m.p.y) - 0.3));
    error.push_back(std::abs(m.p.z - 0.8));
  });
  EXPECT_TRUE(outcome.finite);
  ASSERT_EQ(error.size(), 2u);
  EXPECT_LT(error[0], 0.15);
  EXPECT_LT(error[1], 0.1);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
}

// A fifth is lost, a tenth is no number, some come twice or out of order, all late. The task goes
// on, and distances are kept.
TEST(DdsFlights, OverABadLinkTheTaskIsCompletedAndTheHardDistanceKept) {
  const std::string couple =
      "[agent.uav0.sensor]\npitch = 0.5\n[[couple]]\npotential = { too_far = { d_max = 2.0, kappa = 10.0 } "
      "}\nbetween = [\"uav0\", \"uav1\"]\n"
      "felt_by = [\"uav0\"]\nweight = 8.0\n";
  Rig rig(row_of({"1.16", "1.14"}, 5.0, couple));
  double least = 100.0;
  const auto bad = {Kind::drop, Kind::duplicate, Kind::not_finite, Kind::reorder, Kind::delay};
  const LoopOutcome outcome = rig.fly(0.5, [&] {
    for (std::size_t i = 0; i < 2; ++i)
      for (const Kind kind : bad) rig.faults(i).begin(kind);
    for (int k = 0; k < 70; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      least = std::min(least, norm(rig.vehicle(0).motion().p - rig.vehicle(1).motion().p));
    }
    // A mode that is reported late is a set-point too late: it lands over a good link.
    for (std::size_t i = 0; i < 2; ++i)
      for (const Kind kind : bad) rig.faults(i).end(kind);
  });
  EXPECT_TRUE(outcome.finite);
  EXPECT_GE(outcome.updates + outcome.missed, 500);
  EXPECT_GT(least, 0.6);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  expect_well_treated(rig);
  EXPECT_THAT(rig.world->counts()[0], testing::Not(HasSubstr(" 0 not finite")));
}

TEST(DdsFlights, WhatIsDisarmedIsNotArmedAgain) {
  Rig rig(row_of({"1.18", "1.14"}, 20.0));
  rig.fly(0.5, [&] { rig.faults(1).begin(Kind::disarm); });
  EXPECT_EQ(rig.counts_of(1).arm_requests, 1);
  EXPECT_EQ(rig.state(0), LinkState::done);
  EXPECT_EQ(rig.state(1), LinkState::done);
  EXPECT_THAT(rig.world->faults(), Contains("uav1: it was disarmed"));
  EXPECT_FALSE(rig.vehicle(0).armed());
}

TEST(DdsFlights, AVehicleThatFallsSilentIsGivenUpInTimeAndTheOtherLands) {
  Rig rig(row_of({"1.16", "1.16"}, 20.0), {.landing = 5.0});
  rig.fly(0.5, [&] { rig.faults(0).begin(Kind::silent); });
  EXPECT_EQ(rig.state(0), LinkState::done);
  EXPECT_EQ(rig.state(1), LinkState::done);
  EXPECT_FALSE(rig.vehicle(1).armed());
  EXPECT_THAT(rig.world->faults(), Contains("uav0: nothing came from it any more"));
}

TEST(DdsFlights, AnotherProgramThatWritesSetpointsEndsTheFlight) {
  Rig rig(row_of({"1.16"}, 20.0));
  std::optional<RawWriter> rival;
  rig.fly(0.5, [&] {
    rival.emplace(rig.domain->another_participant(), px4_msgs_msg_dds__TrajectorySetpoint__desc,
                  "/px4_0/fmu/in/trajectory_setpoint", of_sensors);
  });
  EXPECT_EQ(rig.state(0), LinkState::done);
  EXPECT_FALSE(rig.vehicle(0).armed());
  EXPECT_THAT(rig.world->faults(), Contains("uav0: another program writes set-points to it"));
}

TEST(DdsFlights, ThePersonWhoAsksToEndSeesAllLand) {
  Rig rig(row_of({"1.16", "1.18"}, 20.0));
  const LoopOutcome outcome = rig.fly(0.5, [&] {
    ++rig.interrupts;
    rig.stop = true;
  });
  EXPECT_TRUE(outcome.stopped);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  for (std::size_t i = 0; i < 2; ++i) EXPECT_FALSE(rig.vehicle(i).armed());
  expect_well_treated(rig);
}

}  // namespace
}  // namespace sightline::dds
