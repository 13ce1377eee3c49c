/// The clocks of the machine, common to all its programs.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>

namespace sightline {

inline constexpr std::int64_t one_second = 1'000'000'000;  ///< [ns]
/// @param t  [ns]
/// @returns  [s]
constexpr double to_seconds(std::integral auto t) { return 1e-9 * static_cast<double>(t); }
/// @param t  [s]
/// @returns  the nearest [ns]
inline std::int64_t to_nanoseconds(double t) { return std::llround(1e9 * t); }

std::int64_t monotonic_now() noexcept;  ///< [ns]
std::int64_t realtime_now() noexcept;   ///< since 1970 [ns]
std::int64_t process_time() noexcept;   ///< of the processor, by all threads of this program [ns]
std::int64_t thread_time() noexcept;    ///< of the processor, by this thread [ns]; without waiting

/// Sleeps until the monotonic clock reaches t [ns]; a signal does not end the sleep early.
void sleep_until(std::int64_t t) noexcept;

/// The first multiple of `period` that is not before t [ns]. Programs that start their periods
/// there share one grid, whatever their start times.
/// @param t       >= 0
/// @param period  > 0
constexpr std::int64_t next_multiple(std::int64_t t, std::int64_t period) {
  return (t + period - 1) / period * period;
}

}  // namespace sightline
