/// Times updates of 32 robots that swap places across a circle, all pairs near each other kept apart.
#pragma once

#include <string_view>

#include "bench/bench.hpp"

namespace sightline {

inline constexpr std::string_view swarm_case_name = "swarm_32";

/// Times of all updates of 26 s, within which they all arrive, and of them at the crossing, 12 to 18 s; the columns of
/// costs and optima are zero. options.progress is told once, how many pairs came near at one time.
std::vector<BenchRow> run_swarm_bench(const BenchOptions& options = {});

}  // namespace sightline
