/// Times the filter on a robot's command with 1, 4 and 16 neighbours that all restrict the command.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bench/bench.hpp"

namespace sightline {

/// barrier_1, barrier_4, barrier_16: a robot is commanded towards uncooperative neighbours of up to
/// 1 m/s on one side. Each is so near that at most 5 cm remain before the robot must evade; floor
/// and world bounds apply too.
std::vector<std::string> barrier_case_names();
bool is_barrier_case(std::string_view name);

/// Times options.updates commands over 500 situations in which the filter changes the command; the
/// columns of a solver are zero. options.progress receives once the number of situations in which
/// no command satisfies all constraints.
BenchRow run_barrier_bench(std::string_view name, const BenchOptions& options = {});

}  // namespace sightline
