#include "sightline/solver/distributed/partition_convergence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/chain_team.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/newton_riccati_of.hpp"

namespace sightline {
namespace {

/// The chain after a second of flight, and a partitioned solver that knows nothing yet.
std::vector<FromOptimum> exchanges_of(paper::Variant variant, int parts, ExchangeOrder order, int count) {
  const Team team = chain(8, variant);
  NewtonRiccati whole(team, default_horizon);
  const std::vector<double> x = fly(whole, chain_start(8), 100);
  PartitionedSolver solver(team, even_parts(team, parts), newton_riccati_of(default_horizon),
                           {.order = order});
  std::vector<double> u(static_cast<std::size_t>(team.nu()));
  for (int k = 0; k < default_horizon.N; ++k) {
    whole.plan(0, u);  // a plan that is not the optimum
    solver.set_plan(k, u);
  }
  return partition_convergence(solver, *make_reference_solver(solver.ocp()), 1.0, x, count);
}

TEST(PartitionConvergence, ExchangeByExchangeSubteamsComeToTheOptimumOfTheWhole) {
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    for (const int parts : {2, 4, 8}) {
      for (const ExchangeOrder order : {ExchangeOrder::jacobi, ExchangeOrder::gauss_seidel}) {
        const std::vector<FromOptimum> exchanges = exchanges_of(variant, parts, order, 40);
        ASSERT_EQ(exchanges.size(), 40u);
        const auto where = ::testing::Message() << parts << " parts, " << to_string(order);
        EXPECT_LE(exchanges.back().input, 1e-7) << where;
        EXPECT_LE(std::abs(exchanges.back().cost), 1e-9) << where;
        EXPECT_LE(exchanges.back().kkt, 1e-7) << where;
        for (std::size_t i = 3; i < exchanges.size(); ++i) {
          if (exchanges[i - 2].input < 1e-7) break;
          EXPECT_LT(exchanges[i].input, exchanges[i - 2].input) << where << ", exchange " << i + 1;
        }
      }
    }
  }
}

TEST(PartitionConvergence, InGaussSeidelOrderErrorsShrinkFasterThanInJacobiOrder) {
  const auto jacobi = exchanges_of(paper::Variant::joint, 4, ExchangeOrder::jacobi, 8);
  const auto seidel = exchanges_of(paper::Variant::joint, 4, ExchangeOrder::gauss_seidel, 8);
  ASSERT_EQ(jacobi.size(), seidel.size());
  EXPECT_LT(seidel.back().input, 0.5 * jacobi.back().input);
}

TEST(PartitionConvergence, TheCostOfAPlanIsTheIntegralOfItsStagesAndItsEnd) {
  Team team;
  auto options = paper::target();
  options.Q_f = {1, 0, 0, 0, 0, 0, 0};
  options.x_ref = std::array<double, 7>{1, 0, 0, 1, 0, 0, 0};
  options.Q = {2, 0, 0, 0, 0, 0, 0};
  options.R = {3, 1, 1, 1};
  team.add(Multirotor{}, options);
  const Ocp ocp(team, default_horizon);
  const std::vector<double> rest = {0, 0, 0, 1, 0, 0, 0}, still(80, 0.0);
  EXPECT_NEAR(horizon_cost(ocp, 0.0, rest, still), 2 * default_horizon.T + 1, 1e-12);
  std::vector<double> turning(80, 0.0);
  for (std::size_t k = 0; k < 20; ++k) turning[4 * k + 3] = 0.5;
  EXPECT_NEAR(horizon_cost(ocp, 0.0, rest, turning), 2 * default_horizon.T + 1 + 0.25 * default_horizon.T,
              1e-12);
}

}  // namespace
}  // namespace sightline
