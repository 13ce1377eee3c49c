// From any start Newton's method finds the optimum, limits hold on the way, and what it says of
// itself is true.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sightline/potentials.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

/// Starts that a solver knows nothing of: the paper's pair anywhere, looking anywhere.

enum class Reach {
  near,  ///< poses within 6 m
  far,   ///< 10 to 40 m from the reference
};

/// The paper's pair; with all built-in potentials, each robot has a band and a fence too.
Team cold_team(paper::Variant variant, bool all_potentials) {
  Team team = paper::team(variant);
  if (!all_potentials) return team;
  for (const AgentId agent : {paper::uav0, paper::uav1}) {
    team.constrain(0.5 * AltitudeBand{.z_min = 0.2, .z_max = 2.5}, agent);
    team.constrain(0.5 * Geofence{{-3, -3, 0}, {3, 3, 3}}, agent);
  }
  return team;
}

/// States of the two: anywhere; or in turn with the target behind, looking apart, in one place, or
/// so far that limits are active.
std::vector<double> cold_start(Random& random, const Team& team, Reach reach, int trial) {
  std::vector<double> x = random_states(random, team, 6.0);
  const std::span<double> a = std::span(x).first(7), b = std::span(x).last(7);
  if (reach == Reach::far) {
    for (const std::span<double> robot : {a, b}) {
      Vec3<double> direction = random_point(random, 1.0);
      direction = (uniform(random, 10.0, 40.0) / norm(direction)) * direction;
      robot[0] = direction.x, robot[1] = direction.y, robot[2] = direction.z + 1.0;
    }
  }
  const double behind = uniform(random, 0.5, 6.0);
  switch (trial % 5) {
    case 0:
      break;
    case 1:  // the target straight behind
      for (std::size_t i = 0; i < 3; ++i) b[i] = a[i];
      for (std::size_t i = 0; i < 2; ++i) b[i] -= behind * a[3 + i];
      break;
    case 2:  // opposing headings
      b[3] = -a[3], b[4] = -a[4];
      break;
    case 3:  // one place
      std::copy_n(a.begin(), 3, b.begin());
      break;
    default:  // saturating
      for (std::size_t i = 0; i < 3; ++i) a[i] = a[i] < 0 ? a[i] - 3.0 : a[i] + 3.0;
  }
  return x;
}

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
