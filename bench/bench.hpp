/// Flies a case in closed loop with a solver, times every update, and compares every input with the optimum.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/cases.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

struct BenchOptions {
  int updates = 6000;                          ///< of the closed loop, 60 s, >= 2
  int ipopt_every = 50;                        ///< updates between two problems that IPOPT solves too, >= 1
  std::int64_t (*allocations)() = nullptr;     ///< counter of this thread's allocations; null: not counted
  std::function<void(int update)> progress{};  ///< told now and then how far the comparison is; may be empty
  bool judged = true;  ///< compared with the optimum; else times alone, of as many updates as one likes
};

struct BenchRow {
  std::string name, solver;
  int agents = 0;
  bool masked = false;
  double median_us = 0.0, p99_us = 0.0, max_us = 0.0;  ///< wall time of an update, the first included
  double first_us = 0.0, p9999_us = 0.0;               ///< the cold start; the longest of ten thousand
  double input_error_max = 0.0;                        ///< |u - u*|, infinity norm, from 2 s on
  double input_error_transient = 0.0;                  ///< of all updates after the first
  double cost = 0.0;                                   ///< sum over the updates of l dt
  std::int64_t allocations = 0;                        ///< in an update, at most
  double krylov_mean = 0.0;                            ///< iterations an update

  double ipopt_median_us = 0.0;   ///< IPOPT's processor time, started at the optimum of the update before
  double ipopt_difference = 0.0;  ///< |u* - IPOPT's u| over whole horizons, infinity norm
  int ipopt_failed = 0;           ///< problems that IPOPT did not solve
  int unconverged = 0;            ///< updates whose u* is not known to 1e-10
};

/// Median, 99th percentile and longest of measured times [us] of the solver newton_riccati.
BenchRow row_of(std::string_view name, int agents, std::vector<double> us);

/// Keeps the calling thread on the core it is on, so that no update pays for moving.
void pin_to_core();

/// @throws std::runtime_error where the flight leaves the finite numbers
BenchRow run_bench(const BenchCase& what, SolverChoice solver, const BenchOptions& options = {});

/// {"machine","compiler","cases":[...]}.
std::string bench_json(const std::vector<BenchRow>& rows);
/// The same and IPOPT's columns, as a table in Markdown.
std::string bench_table(const std::vector<BenchRow>& rows);

}  // namespace sightline
