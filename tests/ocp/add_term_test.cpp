#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::IsEmpty;

TEST(AddTerm, FadesInUnderItsName) {
  ActiveTeam active_team(event_team(3));
  const AgentId uav2{BodyId{2}};
  const Coupling apart{
      .term = 0.5 * KeepOut{}, .between = {uav2, BodyId{0}}, .felt_by = {uav2}, .name = "apart"};
  const Constraint band{.term = 2.0 * AltitudeBand{}, .agent = uav2, .name = "band"};
  EXPECT_THAT(active_team.apply(AddCoupling{apart}, 3.0, 2.0), IsEmpty());
  EXPECT_THAT(active_team.apply(AddConstraint{band}, 3.0, 2.0), IsEmpty());
  EXPECT_TRUE(active_team.has_term("apart") && active_team.has_term("band"));
  const Team team = active_team.team(4.0);
  EXPECT_EQ(team.couplings().back().ramp.at(4.0), 0.5);
  EXPECT_EQ(team.constraints().back().ramp.at(4.0), 0.5);
  EXPECT_EQ(active_team.team(5.0).couplings().back().ramp, Ramp{});
}

}  // namespace
}  // namespace sightline
