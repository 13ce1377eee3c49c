/// Arrival times and delays of the messages of one topic.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "bridges/dds/topics/conversion.hpp"

namespace sightline::dds {

/// Times in [s]. All zero if nothing arrived.
struct ArrivalFigures {
  std::int64_t count = 0;    ///< messages within the window
  double rate = 0.0;         ///< [1/s]
  double gap_longest = 0.0;  ///< longest time between two messages, including the time since the last one
  double age = 0.0;          ///< time since the last message
  // Local real-time clock at arrival minus stamp: delay plus clock offset, negative if the sender's
  // clock is ahead.
  double delay_least = 0.0, delay_median = 0.0;
  double late_median = 0.0, late_p99 = 0.0;  ///< delay beyond that of the fastest messages
};

/// One thread adds without allocation; any thread reads.
class LatencyMonitor {
 public:
  static constexpr Nanoseconds window = 10'000'000'000;

  /// @param sampled  by the sender's clock
  /// @param arrived  by the local monotonic clock
  /// @param late     delay beyond that of the fastest messages; < 0: unknown
  void note(Nanoseconds sampled, Nanoseconds arrived, Nanoseconds late = -1) noexcept {
    const std::uint64_t n = count_.load(std::memory_order_relaxed);
    arrived_[n % places].store(arrived, std::memory_order_relaxed);
    delay_[n % places].store(arrived - sampled, std::memory_order_relaxed);
    late_[n % places].store(late, std::memory_order_relaxed);
    count_.store(n + 1, std::memory_order_release);
  }

  /// Arrival of the newest message; 0: none.
  Nanoseconds last() const noexcept {
    const std::uint64_t n = count_.load(std::memory_order_acquire);
    return n == 0 ? 0 : arrived_[(n - 1) % places].load(std::memory_order_relaxed);
  }

  /// Figures of the last 10 s, at most 1984 messages.
  /// @param now         of the monotonic clock
  /// @param real_ahead  local real-time clock minus monotonic clock
  ArrivalFigures figures(Nanoseconds now, Nanoseconds real_ahead) const;

 private:
  static constexpr std::size_t places = 2048;

  std::array<std::atomic<Nanoseconds>, places> arrived_{}, delay_{}, late_{};
  std::atomic<std::uint64_t> count_{0};
};

}  // namespace sightline::dds
