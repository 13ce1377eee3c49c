#include "sightline/solver/newton/influence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/support/default_horizon.hpp"
#include "tests/support/felt_team.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using test::team_with;

InfluenceGraph graph_of(const Team& team) {
  const Ocp ocp(team, default_horizon);
  return influence_graph(trace_potentials(ocp), static_cast<int>(ocp.agent_bodies().size()));
}

TEST(Influence, TheGraphIsNamedByItsArrows) {
  EXPECT_EQ(graph_of(team_with(3, {})).kind, Influence::none);
  EXPECT_EQ(graph_of(team_with(3, {{0, 1, -1}, {1, 2, -1}})).kind, Influence::mutual);
  const InfluenceGraph chain = graph_of(team_with(4, {{0, 1, 0}, {1, 2, 1}, {2, 3, 2}}));
  EXPECT_EQ(chain.kind, Influence::cascade);
  EXPECT_EQ(chain.depth, 3);
  EXPECT_EQ(chain.depth_of, (std::vector<int>{3, 2, 1, 0}));
  EXPECT_EQ(graph_of(team_with(3, {{0, 1, 0}, {1, 2, 1}, {2, 0, 2}})).kind, Influence::cyclic);
  EXPECT_EQ(graph_of(team_with(3, {{0, 1, 0}, {1, 2, -1}})).kind, Influence::cyclic)
      << "mutual and one-sided";
}

TEST(Influence, InACascadeWhoeverIsSeenStandsBeforeThoseThatFeelIt) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const int n = 2 + static_cast<int>(random() % 12);
    std::vector<int> rank(static_cast<std::size_t>(n));
    std::iota(rank.begin(), rank.end(), 0);
    std::shuffle(rank.begin(), rank.end(), random);
    std::vector<BodyPotential> potentials;
    for (int i = 0; i < 2 * n; ++i) {
      const int a = static_cast<int>(random() % static_cast<unsigned>(n)),
                b = static_cast<int>(random() % static_cast<unsigned>(n));
      if (a == b) continue;
      BodyPotential& p = potentials.emplace_back();
      p.a = a, p.b = b;
      p.ends.a_feels = rank[static_cast<std::size_t>(a)] > rank[static_cast<std::size_t>(b)];
      p.ends.b_feels = !p.ends.a_feels;
    }
    const InfluenceGraph graph = influence_graph(potentials, n);
    ASSERT_NE(graph.kind, Influence::cyclic);
    std::vector<int> place(static_cast<std::size_t>(n), -1);
    for (std::size_t i = 0; i < graph.order.size(); ++i)
      place[static_cast<std::size_t>(graph.order[i])] = static_cast<int>(i);
    EXPECT_EQ(std::count(place.begin(), place.end(), -1), 0);
    for (const BodyPotential& p : potentials) {
      const int seen = p.ends.a_feels ? p.b : p.a, feels = p.ends.a_feels ? p.a : p.b;
      EXPECT_LT(place[static_cast<std::size_t>(seen)], place[static_cast<std::size_t>(feels)]);
      const std::vector<int>& feelers = graph.feelers[static_cast<std::size_t>(seen)];
      EXPECT_EQ(std::count(feelers.begin(), feelers.end(), feels), 1);
    }
  }
}

TEST(Influence, WhereThereAreCyclesNobodyWaitsForWhatIsLater) {
  // 0 is felt by 1, 1 and 2 feel each other, 3 feels 2.
  const InfluenceGraph graph = graph_of(team_with(4, {{3, 2, 3}, {1, 2, -1}, {1, 0, 1}}));
  EXPECT_EQ(graph.kind, Influence::cyclic);
  EXPECT_EQ(graph.order, (std::vector<int>{0, 1, 2, 3}));
}

}  // namespace
}  // namespace sightline
