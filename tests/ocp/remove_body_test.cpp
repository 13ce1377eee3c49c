#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(RemoveBody, WhatOthersFeltOfOneThatVanishedFadesAway) {
  ActiveTeam active_team(event_team(3));
  EXPECT_THAT(active_team.apply(RemoveBody{BodyId{1}}, 1.0, 0.5), IsEmpty());
  const Team fading = active_team.team(1.0);
  const BodyId ghost = fading.find("uav1");
  ASSERT_GE(ghost.index, 0);
  EXPECT_FALSE(fading.is_agent(ghost));
  EXPECT_EQ(fading.couplings().size(), 3U);
  for (const Coupling& c : fading.couplings()) EXPECT_EQ(c.ramp.at(1.25), 0.5);
  EXPECT_EQ(active_team.at_rest_from(1.0), 1.5);
  EXPECT_EQ(active_team.team(1.5).bodies(), 2);
}

TEST(RemoveBody, ARobotThatFailsStaysAnObstacleToThoseThatFeelIt) {
  for (const Afterwards afterwards : {Afterwards::hold, Afterwards::land}) {
    ActiveTeam active_team(event_team(3));
    EXPECT_THAT(active_team.apply(RemoveBody{BodyId{1}, afterwards}, 1.0, 0.0), IsEmpty());
    const Team team = active_team.team(1.0);
    EXPECT_EQ(team.agents().size(), 2U);
    EXPECT_EQ(team.couplings().size(), 3U);  // uav2's; what uav1 felt is over
    EXPECT_FALSE(team.is_agent(team.find("uav1")));
    EXPECT_EQ(active_team.presence(BodyId{1}),
              afterwards == Afterwards::hold ? Presence::hold : Presence::land);
  }
}

}  // namespace
}  // namespace sightline
