// Updates that are shared over threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "sightline/base.hpp"
#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/random_graph.hpp"

namespace sightline {
namespace {

std::vector<double> commands(const test::GraphTeam& flown, int threads) {
  const Horizon horizon{.T = 0.5, .N = 6, .dt = 0.01};
  NewtonRiccatiOptions options;
  if (threads > 1) options.pool = std::make_shared<ThreadPool>(threads);
  NewtonRiccati solver(flown.team, horizon, options);
  Plant plant(flown.team, flown.x0, {.period = horizon.dt});
  std::vector<double> all;
  for (int k = 0; k < 10; ++k) {
    const Solution s = solver.solve(horizon.dt * k, plant.x());
    all.insert(all.end(), s.u.begin(), s.u.end());
    all.insert(all.end(), s.x.begin(), s.x.end());
    plant.step(s.u, horizon.dt);
  }
  return all;
}

TEST(ThreadPools, CommandsAreTheSameWhateverTheThreads) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Random random(seed);
    const test::GraphTeam flown = test::random_graph(random, NewtonRiccatiOptions::shared_from + 5);
    const std::vector<double> alone = commands(flown, 1);
    const int threads = 1 << seed;
    EXPECT_EQ(commands(flown, threads), alone) << "seed " << seed << ", " << threads << " threads";
  }
}

}  // namespace
}  // namespace sightline
