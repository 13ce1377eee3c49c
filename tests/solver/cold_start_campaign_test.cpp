// From any start Newton's method finds the optimum, limits hold on the way, and what it says of itself is true.
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/solver/newton/newton_riccati.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/cold_start.hpp"

namespace sightline {
namespace {

using paper::Variant;

constexpr int steps = 30;
constexpr double residual_reached = 1e-6;

/// Whether `steps` Newton steps reach the optimum from there.
bool reaches(const Team& team, const std::vector<double>& x) {
  NewtonRiccati solver(team, {.T = 1.0, .N = 20, .dt = 0.01}, {.start_steps = 1});
  for (int k = 0; k < steps; ++k) {
    const Solution s = solver.solve(0.0, x);
    for (const double u : s.u) EXPECT_LE(std::fabs(u), 1.0);
    for (const double value : s.x) EXPECT_TRUE(std::isfinite(value));
    EXPECT_EQ(s.status == Status::converged, s.residual <= residual_reached);
    EXPECT_TRUE(gives_plan(s.status));
    if (solver.kkt(0.0, x) <= residual_reached) return true;
  }
  const Status last = solver.solve(0.0, x).status;
  EXPECT_TRUE(last == Status::stepped || last == Status::iteration_limit);
  return false;
}

void expect_reached(Reach reach, int in_a_thousand) {
  const int trials = whole_campaign() ? 3000 : 250;
  for (const Variant variant : {Variant::joint, Variant::masked}) {
    Random random(reach == Reach::near ? 11 : 12);
    int missed = 0;
    for (int trial = 0; trial < trials; ++trial) {
      const Team team = cold_team(variant, trial / 5 % 2 == 1);
      missed += !reaches(team, cold_start(random, team, reach, trial));
    }
    testing::Test::RecordProperty(variant == Variant::joint ? "missed_joint" : "missed_masked", missed);
    EXPECT_LE(missed, trials * in_a_thousand / 1000) << "of " << trials;
  }
}

TEST(ColdStartCampaign, WithinSixMetresTheOptimumIsReached) { expect_reached(Reach::near, 2); }

TEST(ColdStartCampaign, FromTenToFortyMetresTheOptimumIsReached) { expect_reached(Reach::far, 10); }

}  // namespace
}  // namespace sightline
