#include "bridges/dds/fleet_findings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/dds/rig.hpp"

namespace sightline::dds {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const PosesFrom of_motion_capture = {PoseSource::mocap}, of_odometry = {PoseSource::odometry};

/// What is found about the rate of poses that arrive like that: "green 100 poses ...".
Fields rate_found(const Scenario& scenario, const PosesFrom& from, const ArrivalFigures& figures) {
  FindingList list("cart");
  examine_rate(scenario, from, figures, list);
  Fields found;
  for (const Finding& finding : list.take()) {
    EXPECT_EQ(finding.aspect, Aspect::rate);
    found.push_back(fmt::format("{} {}", to_string(finding.light), finding.sentence));
  }
  return found;
}

// fresh is 0.05 s, slow_after 0.2 s.
TEST(FleetFindings, PosesOfMotionCaptureThatAreRareOrHaveAGapAreRed) {
  const Scenario scenario = row_of({"1.16"}, 1.0);
  const ArrivalFigures steady = {.count = 500, .rate = 100.0, .gap_longest = 0.03, .age = 0.004};
  for (const PosesFrom& from : {of_motion_capture, of_odometry})
    EXPECT_THAT(rate_found(scenario, from, steady),
                ElementsAre("green 100 poses a second, the longest gap 0.030 s, the last 0.004 s old"));
  ArrivalFigures rare = steady;
  rare.rate = 30.0;
  for (const PosesFrom& from : {of_motion_capture, of_odometry})
    EXPECT_THAT(rate_found(scenario, from, rare),
                ElementsAre(testing::AllOf(
                    HasSubstr("red 30 poses a second"),
                    HasSubstr("levels flap unless safety.supervisor.fresh = 0.05 s is 0.083 s or more"))));
  ArrivalFigures hidden = steady;
  hidden.gap_longest = 0.3;
  EXPECT_THAT(rate_found(scenario, of_motion_capture, hidden),
              ElementsAre(testing::AllOf(HasSubstr("red 100 poses a second, the longest gap 0.300 s"),
                                         HasSubstr("slow_after = 0.2 s scales commands"))));
  EXPECT_THAT(rate_found(scenario, of_odometry, hidden), ElementsAre(HasSubstr("green 100 poses a second")));
}

TEST(FleetFindings, FewPosesOfMotionCaptureAreUnknownAndNoneAreNoFinding) {
  const Scenario scenario = row_of({"1.16"}, 1.0);
  const ArrivalFigures few = {.count = 5, .rate = 100.0};
  EXPECT_THAT(rate_found(scenario, of_motion_capture, few),
              ElementsAre("unknown 5 poses, too few to judge their rate"));
  EXPECT_THAT(rate_found(scenario, of_odometry, few), testing::IsEmpty());
  EXPECT_THAT(rate_found(scenario, of_motion_capture, {}), testing::IsEmpty());
}

}  // namespace
}  // namespace sightline::dds
