#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(SetReference, AReferenceGoesOverToTheNext) {
  ActiveTeam active_team(event_team(2));
  const AgentId leader{BodyId{0}};
  const std::vector<double> there = {2, 0, 1, 1, 0, 0, 0};
  const Agent before = active_team.team(0.0).agent(leader);
  EXPECT_THAT(active_team.apply(SetReference{leader, Reference(there)}, 3.0, 1.0), IsEmpty());
  const Team team = active_team.team(3.0);
  const Agent& agent = team.agent(leader);
  std::vector<double> x(7), old(7);
  agent.x_ref(3.0, agent.model, x);
  before.x_ref(3.0, agent.model, old);
  EXPECT_EQ(x, old);
  agent.x_ref(4.0, agent.model, x);
  EXPECT_EQ(x, there);
  agent.x_ref(3.5, agent.model, x);
  before.x_ref(3.5, agent.model, old);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(x[i], (old[i] + there[i]) / 2, 1e-12);
  EXPECT_TRUE(active_team.team(4.0).agent(leader).x_ref.is_constant());
}

}  // namespace
}  // namespace sightline
