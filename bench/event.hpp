/// Times updates of a team that changes in flight.
#pragma once

#include <string_view>

#include "bench/bench.hpp"

namespace sightline {

inline constexpr std::string_view event_case_name = "events_8";

/// Eight robots, of which one goes over from a leader to another and back, each 0.5 s, with weights on a ramp of 0.3 s: all
/// updates; the three after each change of the team; the changes themselves. options.progress is told once, how often
/// the team changed.
std::vector<BenchRow> run_event_bench(const BenchOptions& options = {});

}  // namespace sightline
