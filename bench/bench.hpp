/// Flies a case in closed loop with a solver, times every update, and compares every input with the
/// optimum.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/cases.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

struct BenchOptions {
  int updates = 6000;                          ///< of the closed loop, 60 s, >= 2
  int ipopt_every = 50;                        ///< updates between two problems that IPOPT solves too, >= 1
  std::int64_t (*allocations)() = nullptr;     ///< counter of this thread's allocations; null: not counted
  std::function<void(int update)> progress{};  ///< receives the progress of the comparison; may be empty
  bool judged = true;  ///< compare with the optimum; else only times, of any number of updates
  /// Each update begins on the machine's clock, with sleep between, as in a flight in real time.
  bool paced = false;
  double warm_up = 0.0;  ///< of paced updates: LoopOptions::warm_up [s]
};

struct BenchRow {
  std::string name, solver;
  int agents = 0;
  bool masked = false;
  double median_us = 0.0, p99_us = 0.0, max_us = 0.0;  ///< wall time of an update, the first included
  double first_us = 0.0;                               ///< cold start
  double p999_us = 0.0, p9999_us = 0.0;                ///< 99.9th and 99.99th percentile
  double input_error_max = 0.0;                        ///< |u - u*|, infinity norm, from 2 s on
  double input_error_transient = 0.0;                  ///< maximum over all updates after the first
  double cost = 0.0;                                   ///< sum of l dt over the updates
  std::int64_t allocations = 0;                        ///< maximum in one update
  double krylov_mean = 0.0;                            ///< iterations per update

  double ipopt_median_us = 0.0;   ///< IPOPT's processor time, started at the previous optimum
  double ipopt_difference = 0.0;  ///< |u* - IPOPT's u| over whole horizons, infinity norm
  int ipopt_failed = 0;           ///< problems that IPOPT did not solve
  int unconverged = 0;            ///< updates whose u* is not known to 1e-10
};

/// Median, 99th percentile and maximum of measured times [us] of the solver newton_riccati.
BenchRow row_of(std::string_view name, int agents, std::vector<double> us);

/// Pins the calling thread to its present core, so that no update includes a migration.
void pin_to_core();

/// @throws std::runtime_error if the flight has a number that is not finite
BenchRow run_bench(const BenchCase& what, SolverChoice solver, const BenchOptions& options = {});

/// {"machine","compiler","cases":[...]}.
std::string bench_json(const std::vector<BenchRow>& rows);
/// The same and IPOPT's columns, as a Markdown table.
std::string bench_table(const std::vector<BenchRow>& rows);
/// Times of paced updates, as a Markdown table.
std::string paced_table(const std::vector<BenchRow>& rows);

}  // namespace sightline
