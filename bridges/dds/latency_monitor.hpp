/// When the messages of one topic came, and how old they were then.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "bridges/dds/conversion.hpp"

namespace sightline::dds {

/// Times in s. All zero where nothing came.
struct ArrivalFigures {
  std::int64_t count = 0;    ///< within the window
  double rate = 0.0;         ///< [1/s]
  double gap_longest = 0.0;  ///< between two messages, the time since the last one included
  double age = 0.0;          ///< since the last one
  // Arrival by our real-time clock less the stamp: delay and difference of the clocks, negative where theirs is ahead.
  double delay_least = 0.0, delay_median = 0.0, delay_p99 = 0.0;
  double drift = 0.0;  ///< of the least delay, by halves of the window [s/s]; 0 of less than 4 s
};

/// One thread notes, and allocates nothing; any asks.
class LatencyMonitor {
 public:
  static constexpr Nanoseconds window = 10'000'000'000;

  /// @param sampled  by the sender's clock
  /// @param arrived  by our monotonic clock
  void note(Nanoseconds sampled, Nanoseconds arrived) noexcept {
    const std::uint64_t n = count_.load(std::memory_order_relaxed);
    arrived_[n % places].store(arrived, std::memory_order_relaxed);
    delay_[n % places].store(arrived - sampled, std::memory_order_relaxed);
    count_.store(n + 1, std::memory_order_release);
  }

  /// Of the last 10 s, at most 2048 messages.
  /// @param now         of the monotonic clock
  /// @param real_ahead  our real-time clock less the monotonic one
  ArrivalFigures figures(Nanoseconds now, Nanoseconds real_ahead) const;

 private:
  static constexpr std::size_t places = 2048;

  std::array<std::atomic<Nanoseconds>, places> arrived_{}, delay_{};
  std::atomic<std::uint64_t> count_{0};
};

}  // namespace sightline::dds
