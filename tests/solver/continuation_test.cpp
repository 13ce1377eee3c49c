#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/error.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using paper::Variant;
using testing::HasSubstr;

bool usable(std::span<const double> u) {
  return std::all_of(u.begin(), u.end(), [](double v) { return std::fabs(v) <= 1.0; });
}

template <class S>
std::string refusal(const ContinuationOptions& options) {
  return refusal_of([&] { S(paper::target_alone(), {}, options); });
}

template <class S>
class AnyContinuation : public testing::Test {};

using Continuations = testing::Types<Cmscgmres, Cgmres>;
TYPED_TEST_SUITE(AnyContinuation, Continuations);

TYPED_TEST(AnyContinuation, AnOptionOutOfRangeIsRefusedByItsKey) {
  for (const double bad : {0.0, -1.0, not_a_number, infinite}) {
    EXPECT_THAT(refusal<TypeParam>({.zeta = bad}), HasSubstr("solver.zeta = "));
    EXPECT_THAT(refusal<TypeParam>({.alpha = bad}), HasSubstr("solver.alpha = "));
    EXPECT_THAT(refusal<TypeParam>({.difference_step = bad}), HasSubstr("solver.difference_step = "));
    EXPECT_THAT(refusal<TypeParam>({.slack_weight = bad}), HasSubstr("solver.slack_weight = "));
    EXPECT_THAT(refusal<TypeParam>({.tolerance = bad}), HasSubstr("solver.tolerance = "));
  }
  for (const double bad : {-1e-9, not_a_number, infinite}) {
    EXPECT_THAT(refusal<TypeParam>({.gmres_tolerance = bad}), HasSubstr("solver.gmres_tolerance = "));
  }
  for (const int bad : {0, -1, 1001})
    EXPECT_THAT(refusal<TypeParam>({.k_max = bad}), HasSubstr("solver.k_max = "));
  EXPECT_EQ(refusal<TypeParam>({}), "");
}

TYPED_TEST(AnyContinuation, ItStartsAtARootOfTheEmptyHorizon) {
  Random random(1);
  for (int trial = 0; trial < 30; ++trial) {
    // Inputs enter the robots' own costs alone, so that the root is found exactly.
    Team team;
    for (int i = 0; i < 3; ++i) add_random_agent(team, Multirotor{}, random);
    team.couple(1.0 * SensorCone{}, Between{{0}, {1}});
    team.couple(1.0 * KeepOut{}, Between{{1}, {2}});
    TypeParam mpc(team, {.N = 8});
    const Solution s = mpc.solve(uniform(random, 0, 2), random_states(random, team, 2.0));
    EXPECT_LE(s.residual, 1e-9);
    EXPECT_EQ(s.status, Status::converged);
  }
}

TYPED_TEST(AnyContinuation, TheHorizonGrowsFromNothingToItsLength) {
  Team team;
  team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 1, 1}});
  const BodyId ball = team.add(Obstacle{.name = "ball"});
  const Horizon horizon{.T = 2.0, .N = 10};
  TypeParam mpc(team, horizon, {.alpha = 1.5});
  // The ball flies at 1 m/s: what is predicted of it is the time that is looked ahead.
  const auto at = static_cast<std::size_t>(team.state_offset(ball));
  double last = -1e-9;
  fly(mpc, {0, 0, 1, 1, 0, 0, 0, /**/ 5, 0, 0, 1, 0, 0}, 600,
      [&](double t, const std::vector<double>&, const Solution& s) {
        const double ahead = s.x[10 * 13 + at] - s.x[at];
        EXPECT_NEAR(ahead, 2.0 * (1 - std::exp(-1.5 * (t + 0.01))), 0.03) << t;
        EXPECT_GE(ahead, last);
        last = ahead;
      });
  EXPECT_NEAR(last, 2.0, 0.011);
}

TYPED_TEST(AnyContinuation, ADisturbedResidualDecaysByOneMinusZetaDtAnUpdate) {
  for (const double zeta : {10.0, 30.0, 60.0}) {
    TypeParam mpc(paper::team(Variant::joint), {}, {.zeta = zeta});
    std::vector<double> x = fly(mpc, paper::start(), 1000);
    x[0] += 0.01, x[7] -= 0.01;
    std::vector<double> residuals;
    fly(
        mpc, x, 8,
        [&](double, const std::vector<double>&, const Solution& s) { residuals.push_back(s.residual); },
        10.0);
    ASSERT_GT(residuals[0], 1e-3);
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_NEAR(residuals[k + 1] / residuals[k], 1 - 0.01 * zeta, 0.05) << zeta << ", update " << k;
    }
  }
}

TYPED_TEST(AnyContinuation, StatusSaysWhetherTheResidualIsBelowTheTolerance) {
  int converged = 0, stepped = 0;
  for (const double tolerance : {1e-6, 1e-4, 1e-3}) {
    TypeParam mpc(paper::team(Variant::masked), {}, {.k_max = 4, .tolerance = tolerance});
    fly(mpc, paper::start(), 500, [&](double, const std::vector<double>&, const Solution& s) {
      EXPECT_EQ(s.status, s.residual <= tolerance ? Status::converged : Status::stepped);
      (s.status == Status::converged ? converged : stepped) += 1;
      EXPECT_LE(s.iterations, 4);
    });
  }
  EXPECT_GT(converged, 100);
  EXPECT_GT(stepped, 100);
}

TYPED_TEST(AnyContinuation, AStepThatIsShorterThanThePeriodIsNotOneTakenWhole) {
  for (const double zeta : {10.0, 400.0}) {
    TypeParam mpc(paper::team(Variant::joint), {}, {.zeta = zeta, .tolerance = 1e-12});
    fly(mpc, paper::start(), 20, [&](double t, const std::vector<double>&, const Solution& s) {
      if (t == 0) return;  // the root of the empty horizon
      EXPECT_EQ(s.status, 1.0 / zeta >= 0.01 ? Status::stepped : Status::iteration_limit) << zeta;
    });
  }
}

TYPED_TEST(AnyContinuation, WhatIsNotFiniteIsSaidAndThePlanOfBeforeFliesOn) {
  for (const JacobianProduct product : {JacobianProduct::exact, JacobianProduct::forward_difference}) {
    TypeParam mpc(paper::team(Variant::joint), {}, {.jacobian = product});
    const auto x = fly(mpc, paper::start(), 150);
    const auto last = mpc.solve(1.5, x).u;
    const std::vector<double> before(last.begin(), last.end());
    auto far_off = x;
    far_off[0] = 1e200;  // the square of the distance is infinite
    const Solution s = mpc.solve(1.51, far_off);
    EXPECT_EQ(s.status, Status::not_finite);
    for (std::size_t j = 0; j < 8; ++j) EXPECT_NEAR(s.u[j], before[j], 0.05);
    fly(
        mpc, x, 300,
        [&](double t, const std::vector<double>&, const Solution& next) {
          EXPECT_TRUE(usable(next.u));
          EXPECT_TRUE(gives_plan(next.status)) << t;
        },
        1.52);
  }
}

TYPED_TEST(AnyContinuation, ARefusedStateLeavesTheIterateAsItWas) {
  for (const int lost : {1, 5}) {
    TypeParam mpc(paper::team(Variant::masked), {});
    std::vector<double> x = fly(mpc, paper::saturating_start(), 60);
    const auto last = mpc.solve(0.6, x).u;
    const std::vector<double> before(last.begin(), last.end());
    for (int k = 1; k <= lost; ++k) advance(mpc.ocp().team(), x, mpc.solve(0.6 + 0.01 * k, {}).u, 0.01);
    const auto after = mpc.solve(0.61 + 0.01 * lost, x).u;
    for (std::size_t j = 0; j < before.size(); ++j)
      EXPECT_NEAR(after[j], before[j], 0.03 * (1 + lost)) << lost;
  }
}

TYPED_TEST(AnyContinuation, AZetaTooLargeForThePeriodIsHeldToAStableStep) {
  for (const double zeta : {150.0, 200.0, 400.0, 1e4}) {
    TypeParam mpc(paper::team(Variant::joint), {}, {.zeta = zeta});
    const auto x = fly(mpc, paper::start(), 600, [&](double, const std::vector<double>&, const Solution& s) {
      EXPECT_TRUE(usable(s.u));
      EXPECT_TRUE(gives_plan(s.status));
    });
    EXPECT_LE(mpc.kkt(6.0, x), 0.5) << zeta;
  }
}

TYPED_TEST(AnyContinuation, ExactAndDifferenceProductsGiveTheSameUpdate) {
  for (const Variant variant : {Variant::joint, Variant::masked}) {
    TypeParam exact(paper::team(variant), {}, {.gmres_tolerance = 1e-6});
    TypeParam difference(
        paper::team(variant), {},
        {.difference_step = 1e-6, .jacobian = JacobianProduct::forward_difference, .gmres_tolerance = 1e-6});
    double worst = 0.0;
    fly(exact, paper::saturating_start(), 200,
        [&](double t, const std::vector<double>& x, const Solution& s) {
          const auto other = difference.solve(t, x).raw_u;
          for (std::size_t j = 0; j < 8; ++j) worst = std::max(worst, std::fabs(s.raw_u[j] - other[j]));
        });
    EXPECT_LE(worst, 1e-4);
  }
}

TYPED_TEST(AnyContinuation, AMaskedTargetFliesAsIfAloneWhereverItsObserverIs) {
  for (const double far : {0.0, 0.5, 2.0, 10.0}) {
    TypeParam together(paper::team(Variant::masked), {}), alone(paper::target_alone(), {});
    auto start = paper::start();
    start[0] -= far, start[2] += far;
    double worst = 0.0;
    fly(together, start, 400, [&](double t, const std::vector<double>& x, const Solution& s) {
      const auto u = alone.solve(t, std::span(x).subspan(7)).u;
      for (std::size_t j = 0; j < 4; ++j) worst = std::max(worst, std::fabs(s.u[4 + j] - u[j]));
    });
    EXPECT_LE(worst, 1e-8) << far;
  }
}

TYPED_TEST(AnyContinuation, AfterAGapOfHalfASecondItFindsBack) {
  TypeParam mpc(paper::team(Variant::masked), {});
  auto x = fly(mpc, paper::start(), 1000);
  const Team& team = mpc.ocp().team();
  const auto last = mpc.solve(10.0, x).u;
  const std::vector<double> held(last.begin(), last.end());
  for (int k = 0; k < 50; ++k) advance(team, x, held, 0.01);
  double residual = infinite;
  fly(
      mpc, x, 150,
      [&](double, const std::vector<double>&, const Solution& s) {
        EXPECT_TRUE(usable(s.u));
        residual = s.residual;
      },
      10.5);
  EXPECT_LE(residual, 1e-3);
}

TYPED_TEST(AnyContinuation, AskingForTheKktResidualDoesNotDisturbTheFlight) {
  TypeParam requested(paper::team(Variant::joint), {}), left(paper::team(Variant::joint), {});
  fly(requested, paper::start(), 100, [&](double t, const std::vector<double>& x, const Solution& s) {
    const std::vector<double> u(s.u.begin(), s.u.end());
    EXPECT_TRUE(std::isfinite(requested.kkt(t, x)));
    EXPECT_EQ(requested.kkt(t, std::vector<double>(14, not_a_number)), infinite);
    const auto expected = left.solve(t, x).u;
    for (std::size_t j = 0; j < u.size(); ++j) EXPECT_TRUE(same_bits(u[j], expected[j]));
  });
}

TYPED_TEST(AnyContinuation, TheKktResidualIsNoneAtTheRootWithoutLimitsNear) {
  Team team;
  team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 1, 1}, .x_ref = std::vector<double>{0, 0, 1, 0, 0, 0, 0}});
  TypeParam mpc(team, {}, {.slack_weight = 1e-6});
  const auto x = fly(mpc, {0.2, -0.1, 1.1, 1, 0, 0, 0}, 3000);
  EXPECT_LE(mpc.kkt(30.0, x), 1e-6);
}

TYPED_TEST(AnyContinuation, AnInputThatCostsNearlyNothingStaysWithinItsLimits) {
  Team team;
  team.add(Multirotor{}, {.Q = {5, 5, 5, 0, 0, 0, 0}, .R = {1e-4, 1e-4, 1e-4, 1e-4}});
  TypeParam mpc(team, {});
  fly(mpc, {3, -2, 1, 1, 0, 0, 0}, 1000,
      [&](double t, const std::vector<double>&, const Solution& s) { EXPECT_TRUE(usable(s.u)) << t; });
}

TEST(Continuation, SolversOfOneOcpShareItsFormulasAndNewtonRiccatiTracesNone) {
  const Ocp ocp(paper::team(paper::Variant::masked), Horizon{});
  const NewtonRiccati newton(ocp);
  EXPECT_FALSE(ocp.is_traced()) << "it has formulas of its own";
  const Cmscgmres first(ocp);
  ASSERT_TRUE(ocp.is_traced()) << "when it is made, not in its first update";
  const Formulas& formulas = ocp.formulas();
  const Cgmres second(ocp);
  EXPECT_EQ(&first.ocp().formulas(), &formulas);
  EXPECT_EQ(&second.ocp().formulas(), &formulas);
}

}  // namespace
}  // namespace sightline
