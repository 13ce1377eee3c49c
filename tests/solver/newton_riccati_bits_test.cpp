#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "sightline/solver/newton/newton_riccati.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/paper_team.hpp"

namespace sightline {
namespace {

TEST(NewtonRiccati, CompiledAndInterpretedFunctionsGiveTheSameBits) {
  const Team team = paper::team(paper::Variant::joint);
  NewtonRiccati compiled(team, {}), interpreted(team, {}, {.kernels = KernelChoice::interpreted});
  fly(compiled, paper::saturating_start(), 300,
      [&](double t, const std::vector<double>& x, const Solution& s) {
        const Solution other = interpreted.solve(t, x);
        for (std::size_t i = 0; i < s.u.size(); ++i) ASSERT_EQ(s.u[i], other.u[i]) << t;
        ASSERT_EQ(s.residual, other.residual) << t;
      });
}

TEST(NewtonRiccati, MovedItFliesOnBitForBit) {
  const Team team = chain(5, paper::Variant::joint);
  NewtonRiccati stays(team, default_horizon);
  std::vector<NewtonRiccati> solvers;
  const auto make = [&] {
    NewtonRiccati made(team, default_horizon);
    std::vector<double> x = chain_start(5);
    (void)made.solve(0.0, x);
    return std::optional<NewtonRiccati>(std::move(made));
  };
  for (int i = 0; i < 5; ++i) solvers.push_back(std::move(*make()));  // the list grows, and moves them all
  std::swap(solvers[1], solvers[3]);
  std::vector<double> x = chain_start(5);
  (void)stays.solve(0.0, x);
  for (int k = 1; k < 50; ++k) {
    const Solution expected = stays.solve(0.01 * k, x);
    for (NewtonRiccati& solver : solvers) {
      const Solution s = solver.solve(0.01 * k, x);
      ASSERT_TRUE(std::equal(s.u.begin(), s.u.end(), expected.u.begin()));
      ASSERT_EQ(s.residual, expected.residual);
    }
    advance(team, x, expected.u, 0.01);
  }
}

}  // namespace
}  // namespace sightline
