#include "bench/swarm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/base/quantile.hpp"
#include "sightline/loop.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/swap_team.hpp"

namespace sightline {
namespace {

/// The times of the slowest window of one second, by median, among consecutive windows.
std::vector<double> slowest_second(const std::vector<double>& us) {
  const auto window = static_cast<std::ptrdiff_t>(1.0 / bench_horizon.dt + 0.5);
  std::vector<double> slowest;
  double most = -1.0;
  for (auto at = us.begin(); us.end() - at >= window; at += window) {
    const std::vector<double> here(at, at + window);
    if (const double median = quantile(here, 0.5); median > most) most = median, slowest = here;
  }
  return slowest;
}

}  // namespace

bool is_swarm_case(std::string_view name) { return team_size(name, "swarm").has_value(); }

std::vector<BenchRow> run_swarm_bench(std::string_view name, const BenchOptions& options,
                                      const std::shared_ptr<ThreadPool>& pool) {
  if (!is_swarm_case(name)) throw std::invalid_argument(fmt::format("{} is no swarm", name));
  using std::chrono::steady_clock;
  const int robots = *team_size(name, "swarm");
  constexpr int few = 32;
  const int crossing = robots <= few ? 2600 : 6000;  // updates
  const int crossings = (options.updates + crossing - 1) / crossing;
  const Swap swap = Swap::of(robots);
  NewtonRiccati solver(swap.team, bench_horizon, {.pool = pool});
  GuardOptions guarded{.barrier = BarrierMode::report, .period = bench_horizon.dt, .pool = pool};
  guarded.bodies.assign(at(robots), {.d_hard = Swap::d_hard});
  std::vector<double> stamps(at(robots)), added(at(swap.team.nu())), u(added.size());
  std::vector<double> all, both;
  int pairs = 0;
  std::int64_t allocations = 0, before = 0;
  const auto count = [&] { return options.allocations == nullptr ? 0 : options.allocations(); };
  const auto cross = [&] {
    solver.restart();
    Guard guard(swap.team, guarded);
    std::vector<double> x = swap.x0;
    for (int k = 0; k < crossing; ++k) {
      const double t = bench_horizon.dt * k;
      before = count();
      const Solution s = solver.solve(t, x);
      allocations = std::max(allocations, count() - before);
      pairs = std::max(pairs, s.neighbours.pairs);
      if (s.neighbours.left_out > 0)
        throw std::runtime_error(fmt::format("{}: {} near pairs found no room", name, s.neighbours.left_out));
      std::fill(stamps.begin(), stamps.end(), t);
      std::copy(s.u.begin(), s.u.end(), u.begin());
      const ValidStates& estimate = guard.accept_measurement(t, x, stamps);
      const steady_clock::time_point begin = steady_clock::now();
      guard.keep_distances(t, estimate, added, u);
      const double guarding = std::chrono::duration<double>(steady_clock::now() - begin).count();
      if (k > 0) all.push_back(1e6 * s.elapsed), both.push_back(1e6 * (s.elapsed + guarding));
      advance(swap.team, x, s.u, bench_horizon.dt);
    }
  };
  for (int i = 0; i < crossings; ++i) cross();
  if (options.progress) options.progress(pairs);
  std::vector<BenchRow> rows = {
      row_of(name, robots, all), row_of(fmt::format("{}_crossing", name), robots, slowest_second(all)),
      row_of(fmt::format("{}_barrier", name), robots, both),
      row_of(fmt::format("{}_barrier_crossing", name), robots, slowest_second(both))};
  for (BenchRow& row : rows) row.allocations = allocations;
  return rows;
}

}  // namespace sightline
