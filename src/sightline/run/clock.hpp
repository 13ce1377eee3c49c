/// The clocks of the control loop: simulated time and the machine's monotonic clock.
#pragma once

#include <cstdint>

namespace sightline {

/// When a requested team takes over.
enum class TeamDue {
  now,       ///< the loop waits for the team
  if_ready,  ///< in this period if the team is ready, else in a later one
  not_yet,
};

/// Divides time into periods, counted from 0. For one thread.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Starts period 0 now or at the next multiple of the period.
  /// @param period  [s], > 0
  virtual void start(double period) noexcept = 0;
  /// Waits until period k begins.
  /// @return the current period: k, or a later one if k is already over
  virtual std::int64_t wait(std::int64_t k) noexcept = 0;
  /// Whether time stands still while the log catches up.
  virtual bool waits_for_log() const noexcept = 0;
  /// When a team that was requested before period k takes over.
  virtual TeamDue team_due(std::int64_t) const noexcept {
    return waits_for_log() ? TeamDue::now : TeamDue::if_ready;
  }
};

/// Simulated time, as fast as the machine computes. No period is ever missed.
class SimulatedClock final : public Clock {
 public:
  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override { return k; }
  bool waits_for_log() const noexcept override { return true; }
};

/// The machine's monotonic clock. Periods begin at multiples of the period, so all programs of one
/// machine share a grid. A late period is followed by the next one of the grid, so delays do not
/// accumulate. A period that ended before it could begin is missed; the period that runs instead
/// begins at once.
class SteadyClock final : public Clock {
 public:
  void start(double period) noexcept override;
  std::int64_t wait(std::int64_t k) noexcept override;
  bool waits_for_log() const noexcept override { return false; }

 private:
  std::int64_t start_ns_ = 0, period_ns_ = 1;
};

}  // namespace sightline
