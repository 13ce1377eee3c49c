// What is its own; the laws it shares with multiple shooting are in continuation_test.cpp.
#include <gtest/gtest.h>

#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

using paper::Variant;

double cost_of_a_flight(Solver& solver, const std::vector<double>& start, int updates) {
  double cost = 0.0;
  fly(solver, start, updates, [&](double t, const std::vector<double>& x, const Solution& s) {
    cost += 0.01 * stage_cost(solver.ocp().team(), t, x, s.u);
  });
  return cost;
}

TEST(Cgmres, ThePredictionHoldsTheDynamicsExactlyHoweverTheStateJumps) {
  Random random(1);
  Cgmres mpc(paper::team(Variant::joint), {});
  const Ocp& ocp = mpc.ocp();
  const Hamiltonian hamiltonian(ocp);
  std::vector<double> rate(14);
  std::vector<double> x = fly(mpc, paper::start(), 1500);  // the horizon is at its length
  std::vector<double> before;                              // the inputs that the prediction goes by
  for (int k = 0; k < 100; ++k) {
    x[0] += uniform(random, -0.1, 0.1), x[8] += uniform(random, -0.1, 0.1);
    const Solution s = mpc.solve(15.0 + 0.01 * k, x);
    if (k > 0) hamiltonian.flow(s.x.data(), before.data(), rate.data());
    before.assign(s.raw_u.begin(), s.raw_u.end());
    for (std::size_t i = 0; i < 14; ++i) {
      EXPECT_NEAR(s.x[i], x[i], 1e-15);
      if (k > 0) {
        EXPECT_NEAR(s.x[14 + i], s.x[i] + 0.05 * rate[i], 1e-12);
      }
    }
    advance(ocp.team(), x, s.u, 0.01);
  }
}

TEST(Cgmres, WhereBothHaveConvergedTheInputsAndTheOptimalityResidualAreThoseOfCmscgmres) {
  for (const Variant variant : {Variant::joint, Variant::masked}) {
    Cgmres single(paper::team(variant), {});
    Cmscgmres multiple(paper::team(variant), {});
    std::vector<double> x = fly(single, paper::start(), 3000);
    fly(
        multiple, x, 1000, [](double, const std::vector<double>&, const Solution&) {}, 20.0);
    for (int k = 0; k < 200; ++k) {  // both see the states of one flight
      const double t = 30.0 + 0.01 * k;
      const Solution a = single.solve(t, x), b = multiple.solve(t, x);
      if (k >= 150) {
        EXPECT_LE(a.residual, 1e-4);
        EXPECT_NEAR(single.kkt(t, x), multiple.kkt(t, x), 1e-5) << t;
        for (std::size_t j = 0; j < 8; ++j) EXPECT_NEAR(a.raw_u[j], b.raw_u[j], 1e-5) << t;
      }
      advance(single.ocp().team(), x, a.u, 0.01);
    }
  }
}

TEST(Cgmres, TheFlightCostsWhatItDoesWithMultipleShooting) {
  for (const auto& start : {paper::start(), paper::saturating_start()}) {
    for (const Variant variant : {Variant::joint, Variant::masked}) {
      Cgmres single(paper::team(variant), {});
      Cmscgmres multiple(paper::team(variant), {});
      const double expected = cost_of_a_flight(multiple, start, 1500);
      EXPECT_NEAR(cost_of_a_flight(single, start, 1500), expected, 0.01 * expected);
    }
  }
}

}  // namespace
}  // namespace sightline
