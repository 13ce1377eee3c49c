/// Times updates of robots that swap places across a circle, all pairs near each other kept apart.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bench/bench.hpp"
#include "sightline/base/thread_pool.hpp"

namespace sightline {

/// swarm_M of 8 to 1024 robots.
bool is_swarm_case(std::string_view name);

/// Times of all updates of crossings of 26 s with up to 32 robots, within which they all arrive, and of 60 s with more: as
/// many as hold options.updates; and those of the second with the greatest median, "NAME_crossing". "NAME_barrier" and
/// "NAME_barrier_crossing" are the same with the time of all barriers at 0.6 m added, which tell and change nothing. The columns of costs and optima are zero.
/// @param options  .progress is told once, how many pairs came near at one time
/// @param crew     shares updates and barriers
std::vector<BenchRow> run_swarm_bench(std::string_view name, const BenchOptions& options = {},
                                      const std::shared_ptr<ThreadPool>& pool = {});

}  // namespace sightline
