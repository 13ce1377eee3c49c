// scenarios/swarm32.toml, and the same swap from starts that are scattered: nobody comes too near,
// all arrive.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "sightline/scenario.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/swap_team.hpp"

namespace sightline {
namespace {

struct SwapOutcome {
  double least = 1e9, arrival = 0.0;  // [m], [s]
  int pairs = 0, near = 0;            // most along the plans; most within the radius at one time
  int left_out = 0;
};

SwapOutcome flown_swap(Solver& solver, const Swap& swap, const std::vector<double>& x0, double seconds) {
  SwapOutcome o;
  fly(solver, x0, static_cast<int>(seconds / default_horizon.dt),
      [&](double t, const std::vector<double>& x, const Solution& s) {
        o.least = std::min(o.least, swap.least_distance(x));
        if (swap.to_go(x) > 0.3) o.arrival = t + default_horizon.dt;
        o.pairs = std::max(o.pairs, s.neighbours.pairs);
        o.near = std::max(o.near, swap.pairs_within(x, Swap::radius));
        o.left_out = std::max(o.left_out, s.neighbours.left_out);
      });
  return o;
}

TEST(SwarmFlights, TheShippedScenarioKeepsItsWord) {
  const Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/swarm32.toml");
  const Swap swap(32);
  ASSERT_EQ(scenario.x0.size(), swap.x0.size());
  for (std::size_t i = 0; i < swap.x0.size(); ++i) EXPECT_NEAR(scenario.x0[i], swap.x0[i], 1e-3);
  const auto solver = make_solver(scenario.solver, scenario.team, scenario.horizon);
  const SwapOutcome o = flown_swap(*solver, swap, scenario.x0, 40.0);
  EXPECT_GE(o.least, Swap::d_hard);
  EXPECT_LE(o.arrival, 40.0 - 1.0);
  EXPECT_GE(o.pairs, 90);
  EXPECT_GE(o.near, 90);
  EXPECT_EQ(o.left_out, 0);
}

TEST(SwarmFlights, FromScatteredStartsAllArriveAndNoneComesTooNear) {
  for (int seed = 1; seed <= (whole_campaign() ? 100 : 3); ++seed) {
    const Swap swap(32, 8.0, 0.25, 0.4, static_cast<std::uint64_t>(seed));
    NewtonRiccati solver(swap.team, default_horizon);
    const SwapOutcome o = flown_swap(solver, swap, swap.x0, 40.0);
    EXPECT_GE(o.least, Swap::d_hard) << seed;
    EXPECT_LE(o.arrival, 39.0) << seed;
    EXPECT_EQ(o.left_out, 0) << seed;
    RecordProperty("least_" + std::to_string(seed), std::to_string(o.least));
  }
}

// Barrier off: the potential alone keeps them apart. 128 are scenarios/swarm128.toml.
TEST(SwarmFlights, OfManyThatCrossNoneComesTooNearAllArriveAndNoPairIsLeftOut) {
  for (const int robots : whole_campaign() ? std::vector{64, 128, 256} : std::vector{64}) {
    const Swap swap = Swap::of(robots);
    NewtonRiccati solver(swap.team, default_horizon);
    const SwapOutcome o = flown_swap(solver, swap, swap.x0, 60.0);
    EXPECT_GE(o.least, Swap::d_hard) << robots;
    // Of 256 some are still on their last metres.
    if (robots <= 128) {
      EXPECT_LE(o.arrival, 59.0) << robots;
    }
    EXPECT_EQ(o.left_out, 0) << robots;
    std::cout << robots << " robots: least distance " << o.least << " m, all within 0.3 m after " << o.arrival
              << " s, " << o.pairs << " pairs\n";
  }
}

TEST(SwarmFlights, TheScenarioOf128IsTheSwapOf128) {
  const Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/swarm128.toml");
  const Swap swap = Swap::of(128);
  ASSERT_EQ(scenario.x0.size(), swap.x0.size());
  for (std::size_t i = 0; i < swap.x0.size(); ++i) EXPECT_NEAR(scenario.x0[i], swap.x0[i], 1e-3);
  const Swarm &read = scenario.team.swarms().at(0), &made = swap.team.swarms().at(0);
  EXPECT_EQ(read.radius, made.radius);
  EXPECT_EQ(read.capacity, made.capacity);
  EXPECT_EQ(read.term.weight, made.term.weight);
}

}  // namespace
}  // namespace sightline
