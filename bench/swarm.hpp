/// Times updates of robots that swap places across a circle; all near pairs keep apart.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bench/bench.hpp"
#include "sightline/base.hpp"

namespace sightline {

/// Whether a name is swarm_M, of 8 to 1024 robots.
bool is_swarm_case(std::string_view name);

/// Rows: times of all updates; and those of the second with the greatest median, "NAME_crossing". A
/// crossing takes 26 s with up to 32 robots, enough for all to arrive, and 60 s with more. As many
/// crossings run as options.updates requires. "NAME_barrier" and "NAME_barrier_crossing" add the
/// time of all barriers at 0.6 m, which report and change nothing. The columns of costs and optima
/// are zero.
/// @param options  .progress receives once the greatest number of simultaneous near pairs
/// @param pool     shares updates and barriers
std::vector<BenchRow> run_swarm_bench(std::string_view name, const BenchOptions& options = {},
                                      const std::shared_ptr<ThreadPool>& pool = {});

}  // namespace sightline
