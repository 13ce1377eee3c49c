#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/potentials.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/error.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/paper_team.hpp"

namespace sightline {
namespace {

// The paper's pair from far away, with what its solver is told before each update.
template <class SolverKind = NewtonRiccati>
struct ReportedPair {
  explicit ReportedPair(double rate_max = infinity) : solver(team(rate_max), default_horizon) {
    added.assign(8, 0.0);
    before = added;
  }
  static Team team(double rate_max) {
    Team reported;
    const Team pair = paper::team(paper::Variant::joint);
    for (Agent agent : pair.agents()) {
      if (std::isfinite(rate_max)) agent.rate_max.assign(4, rate_max);
      reported.add(std::move(agent));
    }
    for (const Coupling& coupling : pair.couplings()) reported.couple(coupling);
    return reported;
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
  SolverKind solver;
  std::vector<double> added, before, x = paper::saturating_start();
};

template <class SolverKind>
class AppliedInputsOfAll : public testing::Test {};
using Solvers = testing::Types<NewtonRiccati, Cmscgmres, Cgmres>;
TYPED_TEST_SUITE(AppliedInputsOfAll, Solvers);

TYPED_TEST(AppliedInputsOfAll, LimitsHoldForInputsWithWhatIsAdded) {
  ReportedPair<TypeParam> pair;
  pair.added = {0.4, -0.3, 0.2, 0.0, -0.5, 0.0, 0.7, 0.1};
  std::vector<double> low(8, 1.0), high(8, -1.0);
  for (int k = 0; k < 300; ++k) {
    const std::vector<double> sum = pair.step(0.01 * k);
    for (std::size_t i = 0; i < 8; ++i) {
      EXPECT_LE(std::abs(sum[i]), 1.0 + 1e-12);
      low[i] = std::min(low[i], sum[i]), high[i] = std::max(high[i], sum[i]);
    }
  }
  // It uses all that is left; continuation shies away from a limit by its slack.
  const double near = std::is_same_v<TypeParam, NewtonRiccati> ? 1e-12 : 0.05;
  EXPECT_NEAR(*std::max_element(high.begin(), high.end()), 1.0, near);
  EXPECT_NEAR(*std::min_element(low.begin(), low.end()), -1.0, near);
}

TEST(AppliedInputs, InputsMoveNoFasterThanTheyMayAndTheFlightIsHardlyAnother) {
  ReportedPair<> pair(2.0), free;
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
  ReportedPair<> reported, unreported;
  reported.solver.set_applied({std::vector<double>(3), std::vector<double>(8, 1.0)});
  for (int k = 0; k < 20; ++k) {
    const std::span<const double> u = reported.solver.step(0.01 * k, reported.x),
                                  v = unreported.solver.step(0.01 * k, reported.x);
    EXPECT_TRUE(std::equal(u.begin(), u.end(), v.begin()));
  }
}

// A multirotor that leans by a constant besides.
struct CrookedMultirotor : Multirotor {
  Vec2<double> by{};
  template <class S>
  Vec2<S> lean(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> own = Multirotor::lean(x, u);
    return {own.x + by.x, own.y + by.y};
  }
};

// Two robots whose cameras lean with them and that look at each other.
template <class Robot>
Team lookers(const Robot& a, const Robot& b) {
  Team team;
  const AgentId one = team.add(a, {.Q = {1, 1, 1, 0, 0, 0, 0}, .name = "a"});
  const AgentId two = team.add(b, {.Q = {1, 1, 1, 0, 0, 0, 0}, .name = "b"});
  const Bearing leaning{.mount = {.frame = MountFrame::body}};
  team.couple(4.0 * leaning, {one, two}, {one});
  team.couple(4.0 * leaning, {two, one}, {two});
  return team;
}

TEST(AppliedInputs, ALeanThatIsAddedIsPlannedAsOneOfTheModel) {
  const std::vector<Vec2<double>> lean = {{0.1, -0.06}, {-0.04, 0.12}};
  CrookedMultirotor a, b;
  a.by = lean[0], b.by = lean[1];
  const Team plain = lookers(Multirotor{}, Multirotor{}), crooked = lookers(a, b);
  const std::vector<double> nothing(8), start = {-1, 0, 1, 1, 0, 0, 0, /**/ 1, 0.5, 1.5, -1, 0, 0, 0};
  const MakeSolver newton = newton_riccati_of(default_horizon);
  const Partition alone = {{AgentId{{0}}}, {AgentId{{1}}}};
  const auto flown = [&](Solver& solver, bool reported) {
    std::vector<double> x = start, all;
    for (int k = 0; k < 100; ++k) {
      solver.set_applied({nothing, nothing, reported ? lean : std::vector<Vec2<double>>(2)});
      const auto u = solver.step(0.01 * k, x);
      all.insert(all.end(), u.begin(), u.end());
      advance(solver.ocp().team(), x, u, 0.01);
    }
    return all;
  };
  const auto whole = newton(plain), unreported = newton(plain), expected = newton(crooked);
  const auto u = flown(*whole, true);
  EXPECT_LT(largest_difference(u, flown(*expected, false)), 1e-5)
      << "where a step of robots that feel each other is left off";
  EXPECT_GT(largest_difference(u, flown(*unreported, false)), 0.01);
  PartitionedSolver parts(plain, alone, newton), parts_expected(crooked, alone, newton);
  EXPECT_LT(largest_difference(flown(parts, true), flown(parts_expected, false)), 1e-9);
}

}  // namespace
}  // namespace sightline
