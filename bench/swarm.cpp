#include "bench/swarm.hpp"

#include <algorithm>

#include "sightline/solver/newton/newton_riccati.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/swap_team.hpp"

namespace sightline {

std::vector<BenchRow> run_swarm_bench(const BenchOptions& options) {
  constexpr int updates = 2600;
  const Swap swap(32);
  NewtonRiccati solver(swap.team, bench_horizon);
  std::vector<double> all, crossing;
  int pairs = 0;
  std::int64_t allocations = 0, before = 0;
  const auto count = [&] { return options.allocations == nullptr ? 0 : options.allocations(); };
  std::vector<double> x = swap.x0;
  for (int k = 0; k < updates; ++k) {
    const double t = bench_horizon.dt * k;
    before = count();
    const Solution s = solver.solve(t, x);
    allocations = std::max(allocations, count() - before);
    pairs = std::max(pairs, s.neighbours.pairs);
    if (k > 0) all.push_back(1e6 * s.elapsed);
    if (t >= 12.0 && t < 18.0) crossing.push_back(1e6 * s.elapsed);
    advance(swap.team, x, s.u, bench_horizon.dt);
  }
  if (options.progress) options.progress(pairs);
  std::vector<BenchRow> rows = {row_of(swarm_case_name, 32, all), row_of("swarm_32_crossing", 32, crossing)};
  for (BenchRow& row : rows) row.allocations = allocations;
  return rows;
}

}  // namespace sightline
