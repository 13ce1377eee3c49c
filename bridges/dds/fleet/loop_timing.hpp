/// Measures without a flight whether this machine keeps the periods of a scenario's control loop.
#pragma once

#include <atomic>
#include <cstdint>

#include "bridges/dds/fleet/finding.hpp"
#include "sightline/run/realtime.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Times in s.
struct LoopTiming {
  double period = 0.0;
  std::int64_t periods = 0, missed = 0;  ///< missed: ended before they could begin; of `periods`
  double update_median = 0.0, update_p99 = 0.0,
         update_most = 0.0;  ///< from measurement to command, and the rest of the update
  double wake_p99 = 0.0;     ///< from the begin of a period until the loop runs
  Realtime realtime{};

  /// Red if more than 2 % of the periods are missed, or the 99th percentile of the updates exceeds
  /// a period.
  Finding finding() const;
};

/// Simulates the scenario at the pace of the wall clock, in a thread that requests the same
/// real-time settings as a flight.
/// @param seconds  duration, > 0
/// @param stop     true ends it earlier
/// @throws std::invalid_argument as ClosedLoop and Controls
LoopTiming time_loop(Scenario scenario, double seconds, const std::atomic<bool>* stop = nullptr);

}  // namespace sightline
