#include "sightline/run/warm_up.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/random_graph.hpp"
#include "tests/support/swap_team.hpp"

namespace sightline {
namespace {

enum class Warms { never, before_each, twice_before_some };

std::vector<double> flown_inputs(const Team& team, const std::vector<double>& x0, Warms warms, int threads) {
  const Horizon horizon{.T = 0.5, .N = 6, .dt = 0.01};
  NewtonRiccatiOptions options;
  if (threads > 1) options.pool = std::make_shared<ThreadPool>(threads);
  NewtonRiccati solver(team, horizon, options);
  Plant plant(team, x0, {.period = horizon.dt});
  std::vector<double> all;
  for (int k = 0; k < 40; ++k) {
    if (warms == Warms::before_each) solver.warm_up();
    if (warms == Warms::twice_before_some && k % 3 == 2) solver.warm_up(), solver.warm_up();
    const Solution s = solver.solve(horizon.dt * k, plant.x());
    all.insert(all.end(), s.u.begin(), s.u.end());
    all.insert(all.end(), s.raw_u.begin(), s.raw_u.end());
    all.insert(all.end(), s.x.begin(), s.x.end());
    all.push_back(s.residual);
    plant.step(s.u, horizon.dt);
  }
  return all;
}

void expect_same_flights(const Team& team, const std::vector<double>& x0, int threads) {
  const std::vector<double> cold = flown_inputs(team, x0, Warms::never, threads);
  EXPECT_EQ(flown_inputs(team, x0, Warms::before_each, threads), cold);
  EXPECT_EQ(flown_inputs(team, x0, Warms::twice_before_some, threads), cold);
}

// Couplings of random graphs: mutual, in cascades and with cycles; inputs reach their limits.
TEST(WarmUp, ChangesNoResultOfAnUpdate) {
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    Random random(seed);
    const test::GraphTeam flown = test::random_graph(random, seed % 2 == 0 ? 4 : 9);
    SCOPED_TRACE(seed);
    expect_same_flights(flown.team, flown.x0, 1);
  }
}

TEST(WarmUp, ChangesNoResultOfAnUpdateThatIsSharedOverThreads) {
  Random random(7);
  const test::GraphTeam flown = test::random_graph(random, NewtonRiccatiOptions::shared_from + 3);
  expect_same_flights(flown.team, flown.x0, 2);
}

TEST(WarmUp, ChangesNoResultWithSwarms) {
  const Swap swap(8, 4.0);
  expect_same_flights(swap.team, swap.x0, 1);
}

/// A clock of periods of 10 ms whose time passes only by waiting.
class HeldClock final : public Clock {
 public:
  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override { return k; }
  bool wait_before(std::int64_t, double ahead) noexcept override {
    waits.push_back(ahead);
    return has_time;
  }
  bool waits_for_log() const noexcept override { return false; }

  bool has_time = true;
  std::vector<double> waits;
};

TEST(WarmUp, WaitsNoLongerThanItsBudgetAndStopsIfItTakesMore) {
  HeldClock clock;
  int calls = 0;
  WarmUp none(0.0);
  none.before(clock, 0, [&] { ++calls; });
  EXPECT_EQ(calls, 0);
  EXPECT_TRUE(clock.waits.empty());

  constexpr double budget = 2e-4;
  WarmUp slow(budget);
  const auto longer = [&] {
    ++calls;
    const std::int64_t begin = monotonic_now();
    while (monotonic_now() - begin < 1'000'000) {
    }
  };
  for (std::int64_t k = 0; k < 300; ++k) slow.before(clock, k, longer);
  EXPECT_EQ(calls, 3);  // periods 0, 128 and 256
  for (const double ahead : clock.waits) EXPECT_LE(ahead, budget);

  clock.has_time = false;
  slow.before(clock, 384, longer);
  EXPECT_EQ(calls, 3);
}

}  // namespace
}  // namespace sightline
