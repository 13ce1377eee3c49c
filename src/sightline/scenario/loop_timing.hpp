/// Whether this machine keeps the periods of a scenario: its control loop, timed without a flight.
#pragma once

#include <atomic>
#include <cstdint>

#include "sightline/run/realtime.hpp"
#include "sightline/scenario/finding.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// Times in s.
struct LoopTiming {
  double period = 0.0;
  std::int64_t periods = 0, missed = 0;  ///< missed: over before they could begin; of `periods`
  double update_median = 0.0, update_p99 = 0.0,
         update_most = 0.0;  ///< measurement to command, and what follows
  double wake_p99 = 0.0;     ///< from a period's begin until the loop runs
  Realtime realtime{};

  /// Red where more than 2 % are missed, or the 99th percentile of the updates is longer than a period.
  Finding finding() const;
};

/// Flies the scenario in its model at the wall clock's pace, in a thread that asks for what a flight asks for.
/// @param seconds  how long, > 0
/// @param stop     ends it earlier once it is true
/// @throws std::invalid_argument as ClosedLoop and Controls
LoopTiming time_loop(Scenario scenario, double seconds, const std::atomic<bool>* stop = nullptr);

}  // namespace sightline
