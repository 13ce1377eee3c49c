// The guess from which an update of NewtonRiccati begins: extrapolate.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sightline/solvers.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/error.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Values = std::vector<double>;

/// A solver that begins with the plan before as it was.
class Held {
 public:
  explicit Held(const Team& team) : solver_(team, default_horizon), u_(static_cast<std::size_t>(team.nu())) {}
  Solution solve(double t, const Values& x) {
    for (int k = 0; started_ && k < default_horizon.N; ++k) {
      solver_.plan(k, u_);
      solver_.set_plan(k, u_);
    }
    started_ = true;
    return solver_.solve(t, x);
  }

 private:
  NewtonRiccati solver_;
  Values u_;
  bool started_ = false;
};

struct Errors {
  double own = 0.0, held = 0.0;
};
/// Mean of |u - u*| over a closed loop of 3 s from `since` on, where states are measured with noise
/// of `sigma`.
Errors errors(const Team& team, Values x, double since, double sigma, double period = 0.01,
              const NewtonRiccatiOptions& options = {}) {
  NewtonRiccati own(team, default_horizon, options),
      optimum(team, default_horizon,
              {.max_newton_steps = 40, .tolerance = 1e-11, .max_krylov = 80, .krylov_stop = 1e-12});
  Held held(team);
  Random random(3);
  Errors sum;
  int updates = 0;
  for (double t = 0.0; t < 3.0; t += period) {
    Values measured = x;
    for (double& entry : measured) entry += sigma * uniform(random, -1.7, 1.7);
    const Solution best = optimum.solve(t, measured), a = own.solve(t, measured), b = held.solve(t, measured);
    if (t >= since) {
      ++updates;
      sum.own += largest_difference(a.u, best.u);
      sum.held += largest_difference(b.u, best.u);
    }
    advance(team, x, best.u, period);
  }
  return {sum.own / updates, sum.held / updates};
}

TEST(Foresight, WhereATeamMovesSmoothlyTheErrorIsASmallPartOfThatFromThePlanBefore) {
  for (const auto variant : {paper::Variant::joint, paper::Variant::masked}) {
    const Errors smooth = errors(chain(4, variant), chain_start(4), 1.0, 0.0);
    EXPECT_LT(smooth.own, 0.1 * smooth.held);
  }
  const Errors saturating = errors(paper::team(paper::Variant::joint), paper::saturating_start(), 0.2, 0.0);
  EXPECT_LT(saturating.own, 0.3 * saturating.held);
}

// The guess is off by O(dt^2), and an exact Newton step leaves its square.
TEST(Foresight, HalfThePeriodLeavesASixteenthOfTheError) {
  const Team team = chain(4, paper::Variant::joint);
  const auto error = [&](double period) {
    return errors(team, chain_start(4), 1.5, 0.0, period, {.max_krylov = 80, .krylov_stop = 1e-12}).own;
  };
  const double coarse = error(0.02), fine = error(0.01);
  EXPECT_GT(coarse, 10 * fine) << coarse << ' ' << fine;
}

TEST(Foresight, WhereMeasurementsJumpItIsGivenUp) {
  for (const double sigma : {0.001, 0.01, 0.03}) {
    const Errors noisy = errors(chain(4, paper::Variant::joint), chain_start(4), 1.0, sigma);
    EXPECT_LT(noisy.own, 1.3 * noisy.held) << sigma;
  }
}

}  // namespace
}  // namespace sightline
