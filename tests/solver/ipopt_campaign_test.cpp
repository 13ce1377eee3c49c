// Converged Newton and IPOPT, which share nothing but the formulas, on random problems of two to
// six robots.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "bench/ipopt.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

constexpr double same = 1e-6;  // of every input of the horizon

std::vector<double> plan_of(const NewtonRiccati& solver) {
  const std::size_t nu = static_cast<std::size_t>(solver.ocp().nu());
  std::vector<double> u(nu * static_cast<std::size_t>(default_horizon.N));
  for (int k = 0; k < default_horizon.N; ++k)
    solver.plan(k, std::span(u).subspan(nu * static_cast<std::size_t>(k), nu));
  return u;
}

struct Tally {
  int problems = 0;
  int converged = 0;  // ours
  int stayed = 0;     // IPOPT, begun at our optimum, is at it still
  int left = 0;       // it went elsewhere
  int together = 0;   // both begun at u = 0, and at one optimum
  int ours_lower = 0, ipopt_lower = 0;
  int ipopt_failed = 0;
  double worst = 0.0;  // difference where both are at one optimum
};

void compare(Random& random, Tally& tally) {
  const Team team =
      random_team(random, 2 + static_cast<int>(random() % 5), Feeling::everyone, RandomRobots::any_size);
  const Ocp ocp(team, default_horizon);
  std::vector<double> x = random_states(random, team, uniform(random, 1.0, 4.0));
  for (int i = 0; i < team.bodies(); ++i)
    (void)team.model(BodyId{i}).normalise(&x[static_cast<std::size_t>(team.state_offset(BodyId{i}))]);
  const double t = uniform(random, 0.0, 2.0);
  ++tally.problems;
  NewtonRiccati solver(ocp, {.tolerance = 1e-10, .max_krylov = 100, .krylov_stop = 1e-12, .start_steps = 60});
  if (solver.solve(t, x).status != Status::converged) return;
  ++tally.converged;
  const std::vector<double> ours = plan_of(solver);
  IpoptReference ipopt(ocp);
  try {
    const Optimum near = ipopt.solve(t, x, ours);
    const double moved = largest_difference(ours, near.u);
    ++(moved <= same ? tally.stayed : tally.left);
    if (moved <= same) tally.worst = std::max(tally.worst, moved);
    const Optimum other = ipopt.solve(t, x, std::vector<double>(ours.size(), 0.0), Guess::far);
    if (largest_difference(ours, other.u) <= same) {
      ++tally.together;
    } else {
      ++(near.cost < other.cost ? tally.ours_lower : tally.ipopt_lower);
    }
  } catch (const std::runtime_error&) {
    ++tally.ipopt_failed;
  }
}

TEST(IpoptCampaign, BothFindTheSameInputsWhereTheyFindTheSameOptimum) {
  const int problems = runs(200, 20);
  Random random(5);
  Tally tally;
  for (int i = 0; i < problems; ++i) compare(random, tally);
  std::printf(
      "%d problems, %d converged; IPOPT from our optimum: %d stayed (largest difference %.1e), %d left; from "
      "u = 0: %d at "
      "our optimum, %d at a higher one, %d at a lower one; %d not solved by IPOPT\n",
      tally.problems, tally.converged, tally.stayed, tally.worst, tally.left, tally.together,
      tally.ours_lower, tally.ipopt_lower, tally.ipopt_failed);
  EXPECT_GE(tally.converged, problems * 98 / 100);
  EXPECT_GE(tally.stayed, tally.converged * 99 / 100);
  EXPECT_GE(tally.together, tally.converged * 90 / 100);
}

}  // namespace
}  // namespace sightline
