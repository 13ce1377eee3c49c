/// Times updates of a team that changes in flight.
#pragma once

#include <string_view>

#include "bench/bench.hpp"

namespace sightline {

inline constexpr std::string_view event_case_name = "events_8";

/// Eight robots, one of which changes between two leaders every 0.5 s, with weights on a ramp of
/// 0.3 s. The rows are: all updates; the three updates after each change of the team; the changes
/// themselves. options.progress receives once the number of team changes.
std::vector<BenchRow> run_event_bench(const BenchOptions& options = {});

}  // namespace sightline
