#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/solver/newton/newton_riccati.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/paper_team.hpp"

namespace sightline {
namespace {

// The paper's pair from far away, with what its solver is told before each update.
struct ToldPair {
  explicit ToldPair(double rate_max = infinity) : solver(team(rate_max), default_horizon) {
    added.assign(8, 0.0);
    before = added;
  }
  static Team team(double rate_max) {
    Team told;
    const Team pair = paper::team(paper::Variant::joint);
    for (Agent agent : pair.agents()) {
      if (std::isfinite(rate_max)) agent.rate_max.assign(4, rate_max);
      told.add(std::move(agent));
    }
    for (const Coupling& coupling : pair.couplings()) told.couple(coupling);
    return told;
  }
  /// @return the inputs with what is added
  std::vector<double> step(double t) {
    solver.set_applied({before, added});
    const std::span<const double> u = solver.step(t, x);
    for (std::size_t i = 0; i < 8; ++i) before[i] = u[i] + added[i];
    advance(solver.ocp().team(), x, u, 0.01);
    return before;
  }

  static constexpr double infinity = std::numeric_limits<double>::infinity();
  NewtonRiccati solver;
  std::vector<double> added, before, x = paper::saturating_start();
};

TEST(AppliedInputs, LimitsHoldForItsInputsWithWhatIsAdded) {
  ToldPair pair;
  pair.added = {0.4, -0.3, 0.2, 0.0, -0.5, 0.0, 0.7, 0.1};
  std::vector<double> low(8, 1.0), high(8, -1.0);
  for (int k = 0; k < 300; ++k) {
    const std::vector<double> sum = pair.step(0.01 * k);
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_LE(std::abs(sum[i]), 1.0 + 1e-12);
      low[i] = std::min(low[i], sum[i]), high[i] = std::max(high[i], sum[i]);
    }
  }
  // It uses all that is left.
  EXPECT_NEAR(*std::max_element(high.begin(), high.end()), 1.0, 1e-12);
  EXPECT_NEAR(*std::min_element(low.begin(), low.end()), -1.0, 1e-12);
}

TEST(AppliedInputs, InputsMoveNoFasterThanTheyMayAndTheFlightIsHardlyAnother) {
  ToldPair pair(2.0), free;
  double fastest = 0.0, jump = 0.0;
  for (int k = 0; k < 1500; ++k) {
    const std::vector<double> u0 = pair.before, v0 = free.before;
    const std::vector<double> u = pair.step(0.01 * k), v = free.step(0.01 * k);
    for (std::size_t i = 0; i < 8; ++i) {
      fastest = std::max(fastest, std::abs(u[i] - u0[i]) / 0.01);
      jump = std::max(jump, std::abs(v[i] - v0[i]) / 0.01);
    }
  }
  EXPECT_LE(fastest, 2.0 + 1e-9);
  EXPECT_GT(jump, 50.0);
  for (std::size_t i = 0; i < 14; ++i) EXPECT_NEAR(pair.x[i], free.x[i], 0.1) << i;
}

TEST(AppliedInputs, WhatItIsToldOfAnotherSizeIsNothing) {
  ToldPair told, untold;
  told.solver.set_applied({std::vector<double>(3), std::vector<double>(8, 1.0)});
  for (int k = 0; k < 20; ++k) {
    const std::span<const double> u = told.solver.step(0.01 * k, told.x),
                                  v = untold.solver.step(0.01 * k, told.x);
    EXPECT_TRUE(std::equal(u.begin(), u.end(), v.begin()));
  }
}

}  // namespace
}  // namespace sightline
