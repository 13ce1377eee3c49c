// Teams of 2 to 200 robots of any graph, strongly coupled: the converged solve is stationary, and
// real-time steps do not diverge.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/random_graph.hpp"

namespace sightline {
namespace {

constexpr Horizon of_graphs{.T = 1.0, .N = 20, .dt = 0.01};

int drawn_size(Random& random, int most) {
  return static_cast<int>(std::lround(2.0 * std::pow(most / 2.0, uniform(random, 0.0, 1.0))));
}

/// Whether the solve converges: then to where the conditions of optimality hold. If not, it says
/// so.
bool converges(const test::GraphTeam& drawn) {
  NewtonRiccati solver(drawn.team, of_graphs,
                       {.max_newton_steps = 60,
                        .tolerance = 1e-9,
                        .max_krylov = 200,
                        .krylov_stop = 1e-12,
                        .start_steps = 200});
  Solution s = solver.solve(0.0, drawn.x0);
  for (int more = 0; more < 5 && s.status != Status::converged; ++more) s = solver.solve(0.0, drawn.x0);
  const bool converged = s.status == Status::converged;
  if (converged) {
    EXPECT_LE(solver.kkt(0.0, drawn.x0), 1e-8);
  } else {
    EXPECT_GT(s.residual, 1e-9);
  }
  return converged;
}

TEST(RandomGraphs, TheConvergedSolveIsStationaryOrSaysThatItIsNot) {
  const int graphs = whole_campaign() ? 1000 : 12, largest = whole_campaign() ? 200 : 40;
  Random random(21);
  int missed = 0;
  for (int trial = 0; trial < graphs; ++trial) {
    SCOPED_TRACE(trial);
    missed += !converges(test::random_graph(random, drawn_size(random, largest)));
  }
  std::printf("%d of %d graphs converged, the others say that they did not\n", graphs - missed, graphs);
  EXPECT_LE(missed, graphs / 100);
}

TEST(RandomGraphs, OfAFewRobotsConvergeWhoeverFeelsWhom) {
  const int graphs = whole_campaign() ? 2000 : 120;
  Random random(2);
  int missed = 0;
  for (int trial = 0; trial < graphs; ++trial) {
    SCOPED_TRACE(trial);
    missed += !converges(test::random_graph(random, 3 + trial % 3));
  }
  EXPECT_LE(missed, graphs / 1000);
}

TEST(RandomGraphs, RealTimeStepsDoNotDiverge) {
  const int graphs = whole_campaign() ? 1000 : 4, largest = whole_campaign() ? 200 : 30;
  Random random(22);
  double farthest = 0.0;
  for (int trial = 0; trial < graphs; ++trial) {
    const test::GraphTeam drawn = test::random_graph(random, drawn_size(random, largest));
    NewtonRiccati solver(drawn.team, of_graphs);
    Plant plant(drawn.team, drawn.x0, {.period = of_graphs.dt});
    for (int k = 0; k < 2000; ++k) {
      const Solution s = solver.solve(of_graphs.dt * k, plant.x());
      ASSERT_TRUE(gives_plan(s.status))
          << "graph " << trial << ", update " << k << ": " << to_string(s.status);
      ASSERT_EQ(s.status == Status::converged, s.residual <= solver.tolerance());
      ASSERT_TRUE(plant.step(s.u, of_graphs.dt)) << "graph " << trial << ", update " << k;
    }
    for (int b = 0; b < drawn.team.bodies(); ++b) {
      const std::size_t at = static_cast<std::size_t>(drawn.team.state_offset(BodyId{b}));
      for (std::size_t i = at; i < at + 3; ++i)
        farthest = std::fmax(farthest, std::fabs(plant.x()[i] - drawn.x0[i]));
    }
  }
  std::printf("%d graphs, 20 s each: at most %.1f m from the start\n", graphs, farthest);
  EXPECT_LE(farthest, 6.0);
}

}  // namespace
}  // namespace sightline
