/// Times the filters of a robot's pose.
#pragma once

#include <string_view>
#include <vector>

#include "bench/bench.hpp"

namespace sightline {

inline constexpr std::string_view estimate_case_name = "estimate";

/// A synthetic flight at 100 Hz with a camera of 30 Hz, each filter: a sample of motion; a sighting that is 80
/// ms late, with all that is
/// applied again for it. options.progress is told once, how many sightings of the last filter were believed.
std::vector<BenchRow> run_estimate_bench(const BenchOptions& options = {});

}  // namespace sightline
