#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(RetuneAgent, ChangesWhatItNamesAndLeavesTheRest) {
  ActiveTeam active_team(event_team(2));
  const AgentId uav1{BodyId{1}};
  const Agent before = active_team.agent(uav1);
  const std::vector<double> Q(7, 0.25), R(4, 2.0);
  EXPECT_THAT(active_team.apply(RetuneAgent{.agent = uav1, .Q = Q, .R = R}, 1.0, 0.0), IsEmpty());
  EXPECT_EQ(active_team.agent(uav1).Q, Q);
  EXPECT_EQ(active_team.agent(uav1).R, R);
  EXPECT_EQ(active_team.agent(uav1).Q_f, before.Q_f);
  EXPECT_EQ(active_team.agent(uav1).u_ref, before.u_ref);
  EXPECT_EQ(active_team.agent(AgentId{BodyId{0}}).Q, event_team(2).agent(AgentId{BodyId{0}}).Q);
}

}  // namespace
}  // namespace sightline
