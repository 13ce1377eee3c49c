/// Times the pose filters of a robot.
#pragma once

#include <string_view>
#include <vector>

#include "bench/bench.hpp"

namespace sightline {

inline constexpr std::string_view estimate_case_name = "estimate";

/// Times each filter on a synthetic flight at 100 Hz with a camera of 30 Hz: one motion sample; one
/// detection that arrives 80 ms late, including the replay of later measurements. options.progress
/// receives once the number of accepted detections of the last filter.
std::vector<BenchRow> run_estimate_bench(const BenchOptions& options = {});

}  // namespace sightline
