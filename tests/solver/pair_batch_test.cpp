#include "sightline/solver/newton/pair_batch.hpp"

#include <gtest/gtest.h>

#include "sightline/potentials.hpp"

namespace sightline {
namespace {

/// Two robots and an obstacle, the first kept from both.
struct Three {
  Team team;
  AgentId first = team.add(Multirotor{}), second = team.add(Multirotor{});
  BodyId obstacle = team.add(Obstacle{"post"});
};

TEST(PairBatch, TakesPairsOfItsFormulaThatAreFeltAlike) {
  Three three;
  const AgentId third = three.team.add(Multirotor{});
  three.team.couple(0.4 * KeepOut{}, {three.first, three.second});
  three.team.couple(0.4 * KeepOut{}, {three.second, third});
  three.team.couple(0.4 * KeepOut{}, {three.first, third}, felt_by(third));
  three.team.couple(0.5 * KeepOut{}, {third, three.first});
  const Ocp ocp(three.team, {.T = 0.3, .N = 3, .dt = 0.01});
  const std::vector<BodyPotential> potentials = trace_potentials(ocp);
  ASSERT_EQ(potentials.size(), 4U);
  const PairBatch batch{{&potentials[0]}, Points(potentials[0].potential, KernelChoice::interpreted)};
  EXPECT_TRUE(batch.suits(potentials[1]));
  EXPECT_FALSE(batch.suits(potentials[2]));
  EXPECT_FALSE(batch.suits(potentials[3]));
}

TEST(PairBatch, ARobotIsPushedFromAnObstacleAsFarAsItSeesOne) {
  Three three;
  three.team.couple(0.4 * KeepOut{}, {three.first, three.obstacle});
  const Ocp ocp(three.team, {.T = 0.3, .N = 3, .dt = 0.01});
  const std::vector<BodyPotential> potentials = trace_potentials(ocp);
  ASSERT_EQ(potentials.size(), 1U);
  Layout layout{.stages = 3, .width = 2};
  layout.add(4, 5);
  layout.agents = {{0, 0}, {0, 1}};
  PairBatch batch{{potentials.data()}, Points(potentials[0].potential, KernelChoice::interpreted)};
  batch.points.resize(layout.stages);
  const StageParameters parameters{Rows(sight_size * 3, layout.stages), Rows(1, layout.stages),
                                   Rows(3, layout.stages)};
  Rows s(1, layout.s_length), c(1, layout.c_length);
  for (int k = 0; k < layout.stages; ++k) s[0][layout.s(0)(k, 0)] = 0.5 + k;
  batch.gather(layout, parameters, s[0]);
  batch.points.derive();
  batch.scatter(layout, c[0]);
  for (int k = 0; k < layout.stages; ++k) {
    EXPECT_LT(c[0][layout.c(0)(k, 0)], 0.0) << k;
    EXPECT_EQ(c[0][layout.c(1)(k, 0)], 0.0) << k;
  }
}

}  // namespace
}  // namespace sightline
