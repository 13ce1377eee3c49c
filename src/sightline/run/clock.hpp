/// Whose time the loop runs on.
#pragma once

#include <cstdint>

namespace sightline {

/// When a team that was asked for takes over.
enum class TeamDue {
  now,       ///< the loop waits for it
  if_ready,  ///< or in a later period
  not_yet,
};

/// Cuts time into periods, counted from 0. One thread.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Period 0 begins now, or in a moment.
  /// @param period  [s], > 0
  virtual void start(double period) noexcept = 0;
  /// Waits until period k begins.
  /// @return the period that runs now: k, or a later one where k is over already
  virtual std::int64_t wait(std::int64_t k) noexcept = 0;
  /// Whether time stands still while the log catches up.
  virtual bool waits_for_log() const noexcept = 0;
  /// Of a team that was asked for before period k.
  virtual TeamDue team_due(std::int64_t) const noexcept {
    return waits_for_log() ? TeamDue::now : TeamDue::if_ready;
  }
};

/// Time as fast as it can be computed; no period is ever missed.
class SimulatedClock final : public Clock {
 public:
  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override { return k; }
  bool waits_for_log() const noexcept override { return true; }
};

/// The machine's monotonic clock. Periods begin at its multiples of the period, so that all programs of one machine share a
/// grid: a late period is followed by the grid's next, no delay adds up; one that was over before it could begin is missed, and
/// the one that runs instead begins at once.
class SteadyClock final : public Clock {
 public:
  void start(double period) noexcept override;
  std::int64_t wait(std::int64_t k) noexcept override;
  bool waits_for_log() const noexcept override { return false; }

 private:
  std::int64_t start_ns_ = 0, period_ns_ = 1;
};

}  // namespace sightline
