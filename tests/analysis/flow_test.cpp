#include "sightline/analysis/flow.hpp"

#include <gtest/gtest.h>

#include "sightline/potentials.hpp"

namespace sightline {
namespace {

constexpr std::array<bool, 4> all_four = {true, true, true, true};

Flow two(double x) { return Flow({{{0, 0, 1}, 0.0, all_four}, {{x, 0, 1}, 3.1, all_four}}); }

TEST(Flow, RobotsWithOneCostRestWhereItIsLeast) {
  Flow flow = two(5.0);
  flow.add(1.0 * TooNear{.d_min = 1.0}, 0, 1, true, true);
  flow.add(1.0 * TooFar{.d_max = 1.2}, 0, 1, true, true);
  const FlowEnd settled = flow.settle();
  EXPECT_FALSE(settled.drift);
  EXPECT_NEAR(norm(settled.bodies[0].p - settled.bodies[1].p), 1.1, 0.02);
}

TEST(Flow, WhoFleesWhatFollowsGoesOnForEver) {
  Flow flow = two(1.0);
  flow.add(1.0 * TooFar{.d_max = 1.0}, 0, 1, true, false);
  flow.add(1.0 * TooNear{.d_min = 3.0}, 0, 1, false, true);
  const FlowEnd settled = flow.settle();
  ASSERT_TRUE(settled.drift);
  EXPECT_GT(settled.drift->x, 1.0);
}

TEST(Flow, ABodyThatIsHeldComesToRestAndWhatCannotMoveStays) {
  Flow flow({{{0, 0, 1}, 0.0, all_four}, {{1, 0, 1}, 3.1, {}}});
  flow.add({0, {0, 0, 1}, {1, 1, 1}});
  flow.add(1.0 * TooNear{.d_min = 3.0}, 0, 1, true, true);
  const FlowEnd settled = flow.settle();
  EXPECT_FALSE(settled.drift);
  EXPECT_LT(settled.bodies[0].p.x, -0.2);
  EXPECT_EQ(settled.bodies[1].p.x, 1.0);
}

TEST(Flow, OfATeamARobotBeginsAtItsReferenceAndOthersStay) {
  Team team;
  const AgentId a =
      team.add(Multirotor{},
               {.Q = {1, 1, 1}, .x_ref = [](double) { return std::array<double, 7>{5, 0, 2, 1, 0, 0, 0}; }});
  const AgentId b = team.add(Multirotor{});
  team.couple(1.0 * TooFar{.d_max = 1.0}, Between{a, b}, felt_by(b));
  const std::vector<double> x0 = {0, 0, 1, 1, 0, 0, 0, 3, 0, 1, 1, 0, 0, 0};
  const FlowEnd settled = flow_of(team, x0, std::array{a}).settle();
  EXPECT_FALSE(settled.drift);
  EXPECT_NEAR(settled.bodies[0].p.x, 5.0, 1e-9);
  EXPECT_EQ(settled.bodies[1].p.x, 3.0);
}

}  // namespace
}  // namespace sightline
