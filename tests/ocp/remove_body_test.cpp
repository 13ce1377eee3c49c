#include "sightline/ocp/event/remove_body.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/ocp/roster.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(RemoveBody, WhatOthersFeltOfOneThatVanishedFadesAway) {
  Roster roster(event_team(3));
  EXPECT_THAT(roster.apply(RemoveBody{BodyId{1}}, 1.0, 0.5), IsEmpty());
  const Team fading = roster.team(1.0);
  const BodyId ghost = fading.find("uav1");
  ASSERT_GE(ghost.index, 0);
  EXPECT_FALSE(fading.is_agent(ghost));
  EXPECT_EQ(fading.couplings().size(), 3U);
  for (const Coupling& c : fading.couplings()) EXPECT_EQ(c.ramp.at(1.25), 0.5);
  EXPECT_EQ(roster.at_rest_from(1.0), 1.5);
  EXPECT_EQ(roster.team(1.5).bodies(), 2);
}

TEST(RemoveBody, ARobotThatFailsStaysAnObstacleToThoseThatFeelIt) {
  for (const Afterwards afterwards : {Afterwards::hold, Afterwards::land}) {
    Roster roster(event_team(3));
    EXPECT_THAT(roster.apply(RemoveBody{BodyId{1}, afterwards}, 1.0, 0.0), IsEmpty());
    const Team team = roster.team(1.0);
    EXPECT_EQ(team.agents().size(), 2U);
    EXPECT_EQ(team.couplings().size(), 3U);  // uav2's; what uav1 felt is over
    EXPECT_FALSE(team.is_agent(team.find("uav1")));
    EXPECT_EQ(roster.presence(BodyId{1}), afterwards == Afterwards::hold ? Presence::hold : Presence::land);
  }
}

TEST(RemoveBody, IsSaid) {
  const Team team = event_team(2);
  const BodyId uav1{1};
  EXPECT_EQ(RemoveBody{uav1}.words(team), "remove uav1");
  EXPECT_EQ((RemoveBody{uav1, Afterwards::hold}.words(team)), "remove uav1, which holds");
  EXPECT_EQ((RemoveBody{uav1, Afterwards::land}.words(team)), "remove uav1, which lands");
}

}  // namespace
}  // namespace sightline
