/// Times the filter on a robot's command with 1, 4 and 16 neighbours that all press.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bench/bench.hpp"

namespace sightline {

/// barrier_1, barrier_4, barrier_16: uncooperative neighbours of up to 1 m/s on one side of a robot that is sent into them, each so near
/// that at most 5 cm are left before it must flee; floor and world bounds too.
std::vector<std::string> barrier_case_names();
bool is_barrier_case(std::string_view name);

/// Times of options.updates commands over 500 situations in which the command is changed; the columns of a solver are
/// zero. options.progress is told once, in how many of them no command keeps all.
BenchRow run_barrier_bench(std::string_view name, const BenchOptions& options = {});

}  // namespace sightline
