// A swarm as the solvers take it, and in closed loop.
#include <gtest/gtest.h>

#include <array>

#include "cli/allocations.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/swap_team.hpp"

namespace sightline {
namespace {

TEST(SwarmSolver, PlansWhatPairsOneByOneWould) {
  Random random(1);
  for (int trial = 0; trial < 6; ++trial) {
    Team by_pairs;
    std::vector<AgentId> robots;
    const Swap swap(6, 1.5, 0.25, 0.4, random());
    for (const Agent& agent : swap.team.agents()) robots.push_back(by_pairs.add(agent));
    for (std::size_t i = 0; i < robots.size(); ++i) {
      for (std::size_t j = i + 1; j < robots.size(); ++j)
        by_pairs.couple(swap.team.swarms()[0].term, {robots[i], robots[j]});
    }
    const NewtonRiccatiOptions options{
        .max_newton_steps = 40, .tolerance = 1e-9, .max_krylov = 60, .krylov_stop = 1e-12, .start_steps = 40};
    NewtonRiccati solver(swap.team, default_horizon, options), other(by_pairs, default_horizon, options);
    const Solution u = solver.solve(0.0, swap.x0), v = other.solve(0.0, swap.x0);
    if (u.status != Status::converged || v.status != Status::converged) continue;
    for (std::size_t i = 0; i < u.u.size(); ++i) EXPECT_NEAR(u.u[i], v.u[i], 1e-3) << trial;
    EXPECT_NEAR(solver.kkt(0.0, swap.x0), 0.0, 1e-3);
  }
}

TEST(SwarmSolver, ContinuationIsRefusedATeamThatKeepsApart) {
  const Swap swap(3);
  const std::string expected = "this solver knows no keep_apart, expected newton_riccati";
  EXPECT_EQ(refusal_of([&] { Cgmres(Ocp(swap.team, default_horizon), {}); }), expected);
  EXPECT_EQ(refusal_of([&] { Cmscgmres(Ocp(swap.team, default_horizon), {}); }), expected);
}

TEST(SwarmSolver, SwapsOfTwoFourAndEightNeverStandStillNorComeTooNear) {
  for (const int robots : {2, 4, 8}) {
    const Swap swap(robots);
    NewtonRiccati solver(swap.team, default_horizon);
    std::vector<double> slow_since(static_cast<std::size_t>(robots), 0.0);
    double least = 1e9, longest = 0.0;
    std::vector<double> end;
    fly(solver, swap.x0, 3000, [&](double t, const std::vector<double>& x, const Solution&) {
      least = std::fmin(least, swap.least_distance(x));
      for (std::size_t i = 0; i < slow_since.size(); ++i) {
        const bool there = norm(Swap::position(x, i) - swap.goals[i]) < 0.3;
        if (there || std::hypot(x[7 * i + 5], x[7 * i + 6]) > 0.1) slow_since[i] = t;
        longest = std::fmax(longest, t - slow_since[i]);
      }
      end = x;
    });
    EXPECT_GE(least, 0.9) << robots;
    EXPECT_LE(longest, 2.0) << robots;
    EXPECT_LE(swap.to_go(end), 0.1) << robots;
  }
}

TEST(SwarmSolver, HeadOnBothPassOnTheirRightAndWithoutDeltaNothingButRoundingPartsThem) {
  for (const double delta : {0.25, 0.0}) {
    const Swap swap(2, 4.0, delta);
    NewtonRiccati solver(swap.team, default_horizon);
    double aside = 0.0;  // of the first, which flies along -x: its right is +y
    fly(solver, swap.x0, 900, [&](double, const std::vector<double>& x, const Solution&) { aside = x[1]; });
    EXPECT_EQ(aside > 0.3, delta > 0.0) << aside;
    EXPECT_EQ(std::fabs(aside) < 0.01, delta == 0.0) << aside;
  }
}

TEST(SwarmSolver, SaysHowManyPairsCountAndHowManyFoundNoRoom) {
  Swap swap(12, 1.6);
  NewtonRiccati solver(swap.team, default_horizon);
  const Solution all = solver.solve(0.0, swap.x0);
  EXPECT_GE(all.neighbours.pairs, swap.pairs_within(swap.x0, Swap::radius));
  EXPECT_EQ(all.neighbours.left_out, 0);
  Team cramped;
  std::vector<AgentId> robots;
  for (const Agent& agent : swap.team.agents()) robots.push_back(cramped.add(agent));
  cramped.keep_apart(swap.team.swarms()[0].term, robots, Swap::radius, 10);
  NewtonRiccati other(cramped, default_horizon);
  const Solution some = other.solve(0.0, swap.x0);
  EXPECT_EQ(some.neighbours.pairs, 10);
  EXPECT_GE(some.neighbours.left_out, swap.pairs_within(swap.x0, Swap::radius) - 10);
}

TEST(SwarmSolver, NoUpdateTakesMemoryAndTheSameStatesGiveTheSameBits) {
  const Swap swap(16, 4.0);
  NewtonRiccati solver(swap.team, default_horizon), same(swap.team, default_horizon);
  fly(solver, swap.x0, 800, [&](double t, const std::vector<double>& x, const Solution& s) {
    const std::int64_t before = cli::allocations();
    const Solution again = same.solve(t, x);
    EXPECT_EQ(cli::allocations(), before);
    EXPECT_TRUE(std::equal(s.u.begin(), s.u.end(), again.u.begin())) << t;
  });
}

}  // namespace
}  // namespace sightline
