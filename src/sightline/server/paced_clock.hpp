/// Clock with an adjustable speed and a pause.
#pragma once

#include <atomic>
#include <cstdint>

#include "sightline/loop.hpp"

namespace sightline {

/// Periods on a fixed grid of the monotonic clock, like SteadyClock, but `speed` times as fast. It
/// never skips a period: a late period shifts the grid. A flight on a busy machine is therefore
/// slower, but the same flight.
class PacedClock final : public Clock {
 public:
  /// @param speed  simulated time over wall time, > 0
  /// @param paused  pauses after the first period, until resume() or `stop`
  PacedClock(double speed, bool paused, const std::atomic<bool>& stop);

  void start(double period) noexcept override;
  std::int64_t wait(std::int64_t k) noexcept override;
  bool waits_for_log() const noexcept override { return true; }

  // For any thread.

  void pause() noexcept { paused_ = true; }
  void resume() noexcept { paused_ = false; }
  /// Lets one more period begin while the clock is paused.
  void step() noexcept { ++steps_; }
  bool paused() const noexcept { return paused_; }

 private:
  double speed_;
  std::atomic<bool> paused_;
  std::atomic<int> steps_{0};  // periods that may still begin
  const std::atomic<bool>& stop_;
  std::int64_t next_ns_ = 0, period_ns_ = 1;
};

}  // namespace sightline
