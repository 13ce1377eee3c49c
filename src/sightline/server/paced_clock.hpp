/// The machine's clock, slower or faster, and stopped until somebody lets it go.
#pragma once

#include <atomic>
#include <cstdint>

#include "sightline/run/clock.hpp"

namespace sightline {

/// Periods on a fixed grid of the monotonic clock, as those of a SteadyClock, but `speed` times as fast. Never skips one: a late one
/// moves the grid, so that a flight that is looked at on a busy machine is slower and not another one.
class PacedClock final : public Clock {
 public:
  /// @param speed   simulated time by that of the wall clock, > 0
  /// @param paused  after the first period waits until resume(), or until `stop` is set
  PacedClock(double speed, bool paused, const std::atomic<bool>& stop);

  void start(double period) noexcept override;
  std::int64_t wait(std::int64_t k) noexcept override;
  bool waits_for_log() const noexcept override { return true; }

  // Of any thread.

  void pause() noexcept { paused_ = true; }
  void resume() noexcept { paused_ = false; }
  /// While it is paused lets one more period begin.
  void step() noexcept { ++steps_; }
  bool paused() const noexcept { return paused_; }

 private:
  double speed_;
  std::atomic<bool> paused_;
  std::atomic<int> steps_{0};  // that may yet begin
  const std::atomic<bool>& stop_;
  std::int64_t next_ns_ = 0, period_ns_ = 1;
};

}  // namespace sightline
