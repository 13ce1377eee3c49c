#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(AddBody, ARobotThatVanishesTakesItsCouplingsAlongAndBringsThemBack) {
  const Team all = event_team(4);
  ActiveTeam active_team(all);
  EXPECT_THAT(active_team.apply(RemoveBody{BodyId{2}}, 1.0, 0.0), IsEmpty());
  const Team without = active_team.team(1.0);
  EXPECT_EQ(without.agents().size(), 3U);
  EXPECT_LT(without.find("uav2").index, 0);
  EXPECT_EQ(without.couplings().size(), 3U);  // of uav1; those of uav2 and of uav3, which saw it, rest
  EXPECT_THAT(active_team.apply(AddBody{BodyId{2}}, 2.0, 0.0), IsEmpty());
  EXPECT_EQ(active_team.team(2.0).couplings().size(), all.couplings().size());
}

}  // namespace
}  // namespace sightline
