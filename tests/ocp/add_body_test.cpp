#include "sightline/ocp/event/add_body.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/ocp/roster.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(AddBody, ARobotThatVanishesTakesItsCouplingsAlongAndBringsThemBack) {
  const Team all = event_team(4);
  Roster roster(all);
  EXPECT_THAT(roster.apply(RemoveBody{BodyId{2}}, 1.0, 0.0), IsEmpty());
  const Team without = roster.team(1.0);
  EXPECT_EQ(without.agents().size(), 3U);
  EXPECT_LT(without.find("uav2").index, 0);
  EXPECT_EQ(without.couplings().size(), 3U);  // of uav1; those of uav2 and of uav3, which saw it, rest
  EXPECT_THAT(roster.apply(AddBody{BodyId{2}}, 2.0, 0.0), IsEmpty());
  EXPECT_EQ(roster.team(2.0).couplings().size(), all.couplings().size());
}

TEST(AddBody, IsSaid) {
  const Team team = event_team(2);
  EXPECT_EQ(AddBody{BodyId{1}}.words(team), "add uav1");
}

}  // namespace
}  // namespace sightline
