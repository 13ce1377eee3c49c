/// Faults of a robot in flight, and what becomes of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/dds/rig.hpp"

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// Two vehicles fly, uav0 gets a fault: all land, because of it.
void expect_landed(Kind kind, const std::string& because) {
  Rig rig(row_of({"1.17", "1.15"}, 20.0));
  const LoopOutcome outcome = rig.fly(0.5, [&] { rig.faults(0).begin(kind); });
  EXPECT_LT(outcome.updates, 400);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(rig.state(i), LinkState::done) << i;
  for (std::size_t i = 0; i < 2; ++i) EXPECT_FALSE(rig.vehicle(i).armed()) << i;
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre("uav0: " + because));
  expect_well_treated(rig);
}

TEST(FaultMatrix, ALowBatteryLandsAll) { expect_landed(Kind::battery_low, "its battery is low"); }

TEST(FaultMatrix, AnEstimatorThatIsNotValidLandsAll) {
  expect_landed(Kind::estimator_invalid, "its estimator is not valid");
}

// Its position is called valid all the while: as an estimator that starts anew in the air says it.
TEST(FaultMatrix, AnEstimatorThatLosesItsHeadingLandsAll) {
  Rig rig(row_of({"1.16", "1.18"}, 20.0));
  const LoopOutcome outcome = rig.fly(0.5, [&] { rig.vehicle(0).aside().set_alignment(true, false); });
  EXPECT_LT(outcome.updates, 400);
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre("uav0: its estimator is not valid"));
  expect_well_treated(rig);
}

/// How far a vehicle truly is from the circle of its reference, 2.5 s after a jump by so much [m].
double off_its_circle(Rig& rig, Kind jump, double size, LoopOutcome& outcome) {
  double off = 0.0;
  outcome = rig.fly(2.0, [&] {
    rig.faults(0).begin(jump, size);
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    const Motion m = rig.vehicle(0).motion();
    off = std::abs(norm(m.p.x, m.p.y) - 0.3);
  });
  return off;
}

// The estimator counts it: the frame moved, and the robot stays on its circle.
TEST(FaultMatrix, AJumpThatTheEstimatorCountsIsTakenAsItsFrames) {
  Rig rig(row_of({"1.16", "1.18"}, 5.0));
  LoopOutcome outcome;
  EXPECT_LT(off_its_circle(rig, Kind::jump_reported, 0.25, outcome), 0.1);
  EXPECT_GE(outcome.updates + outcome.missed, 500);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(rig.occurred[static_cast<std::size_t>(EventKind::measurement_jump)], 0);
  EXPECT_THAT(rig.world->counts(), Contains(HasSubstr("1 jumps of its estimator by 0.2")));
  expect_well_treated(rig);
}

TEST(FaultMatrix, JumpsThatAreCountedButTooFarLandAll) {
  Rig rig(row_of({"1.16", "1.18"}, 20.0));
  const LoopOutcome outcome = rig.fly(0.5, [&] { rig.faults(0).begin(Kind::jump_reported, 0.5); });
  EXPECT_LT(outcome.updates, 400);
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre("uav0: its estimator jumped too far"));
  expect_well_treated(rig);
}

// Nobody counts it: the supervisor doubts, and accepts what goes on being published. It is off its
// circle by the jump.
TEST(FaultMatrix, AJumpThatNobodyCountsIsDoubtedAndThenBelieved) {
  Rig rig(row_of({"1.16", "1.18"}, 5.0));
  LoopOutcome outcome;
  EXPECT_GT(off_its_circle(rig, Kind::jump, 0.5, outcome), 0.1);
  EXPECT_GE(outcome.updates + outcome.missed, 500);
  EXPECT_GT(rig.occurred[static_cast<std::size_t>(EventKind::measurement_jump)], 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  expect_well_treated(rig);
}

TEST(FaultMatrix, PosesThatFreezeForAWhileAreDoubtedAndTheTaskGoesOn) {
  Rig rig(row_of({"1.16", "1.16"}, 3.0));
  const LoopOutcome outcome = rig.fly(0.7, [&] {
    rig.faults(0).begin(Kind::frozen);
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    rig.faults(0).end(Kind::frozen);
  });
  EXPECT_GE(outcome.updates + outcome.missed, 300);
  EXPECT_GT(rig.occurred[static_cast<std::size_t>(EventKind::measurement_frozen)], 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  expect_well_treated(rig);
}

// It begins anew at once, disarmed on the ground, on the same topics.
TEST(FaultMatrix, OneThatRestartsIsNeitherArmedNorSteeredAgain) {
  Rig rig(row_of({"1.16", "1.18"}, 20.0));
  rig.fly(0.5, [&] { rig.faults(0).begin(Kind::restart); });
  EXPECT_EQ(rig.state(0), LinkState::done);
  EXPECT_EQ(rig.state(1), LinkState::done);
  EXPECT_FALSE(rig.vehicle(1).armed());
  const Px4VehicleCounts n = rig.counts_of(0);
  EXPECT_EQ(n.setpoints, 0);
  EXPECT_EQ(n.arm_requests + n.offboard_requests, 0);
  EXPECT_FALSE(rig.vehicle(0).armed());
  EXPECT_THAT(rig.world->faults(), Contains(testing::AnyOf(HasSubstr("uav0: it was restarted"),
                                                           HasSubstr("uav0: it was disarmed"))));
}

}  // namespace
}  // namespace sightline::dds
