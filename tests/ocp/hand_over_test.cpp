#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

HandOver turn_to(int target) {
  const AgentId self{BodyId{2}};
  HandOver change{.observer = self, .names = {"sees2"}};
  if (target >= 0)
    change.couplings = {
        {.term = 0.4 * SensorCone{}, .between = {self, BodyId{target}}, .felt_by = {self}, .name = "sees2"}};
  return change;
}

TEST(HandOver, TheCouplingsOfItsNamesGoOverAndTheOthersStay) {
  ActiveTeam active_team(event_team(3));
  EXPECT_EQ(active_team.apply(turn_to(0), 1.0, 2.0), "");
  EXPECT_EQ(active_team.team(2.0).couplings().size(), 7U) << "both are in force for a while";
  EXPECT_EQ(active_team.team(3.0).couplings().size(), 6U);
  EXPECT_TRUE(active_team.has_term("sees2"));
  EXPECT_EQ(active_team.apply(turn_to(-1), 4.0, 0.0), "");
  EXPECT_FALSE(active_team.has_term("sees2"));
  EXPECT_EQ(active_team.team(4.0).couplings().size(), 5U);
  EXPECT_EQ(active_team.apply(turn_to(1), 5.0, 0.0), "") << "from nobody";
  EXPECT_EQ(active_team.team(5.0).couplings().size(), 6U);
}

TEST(HandOver, WhatIsRefusedChangesNothing) {
  ActiveTeam active_team(event_team(3));
  EXPECT_NE(active_team.apply(turn_to(2), 1.0, 0.0), "");
  EXPECT_TRUE(active_team.has_term("sees2"));
  EXPECT_EQ(active_team.team(1.0).couplings().size(), 6U);
}

}  // namespace
}  // namespace sightline
