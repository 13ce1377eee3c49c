/// Lock-free histogram of durations, with bins of 1.6 to 3.2 % relative width.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>

namespace sightline::dds {

/// One thread adds without allocation; any thread reads. Range: 1 us to 134 s; durations outside
/// count in the first or last bin.
class DelayHistogram {
 public:
  /// @param seconds  ignored if not finite
  void add(double seconds) noexcept {
    if (!std::isfinite(seconds)) return;
    const double us = std::clamp(1e6 * seconds, 1.0, 0.999 * static_cast<double>(std::int64_t{1} << octaves));
    int exponent = 0;
    const double part = std::frexp(us, &exponent);  // mantissa in [0.5, 1)
    const int place = (exponent - 1) * steps + static_cast<int>((2 * part - 1) * steps);
    counts_[static_cast<std::size_t>(place)].fetch_add(1, std::memory_order_relaxed);
  }
  void add(const DelayHistogram& other) noexcept {
    for (std::size_t i = 0; i < counts_.size(); ++i)
      counts_[i].fetch_add(other.counts_[i].load(std::memory_order_relaxed), std::memory_order_relaxed);
  }

  std::int64_t count() const noexcept {
    std::int64_t n = 0;
    for (const auto& one : counts_) n += one.load(std::memory_order_relaxed);
    return n;
  }
  /// Quantile [s]: the upper edge of the bin that holds it, at most 3.2 % too large; 0 if the
  /// histogram is empty.
  /// @param share  in [0, 1]
  double within(double share) const noexcept {
    const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(count())));
    std::int64_t n = 0;
    double last = 0.0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      const std::int64_t here = counts_[i].load(std::memory_order_relaxed);
      if (here == 0) continue;
      n += here;
      const auto octave = static_cast<int>(i) / steps, step = static_cast<int>(i) % steps;
      last = 1e-6 * std::ldexp(1.0 + (step + 1.0) / steps, octave);
      if (n >= wanted) break;
    }
    return last;
  }

 private:
  static constexpr int octaves = 27, steps = 32;
  std::array<std::atomic<std::int64_t>, octaves * steps> counts_{};
};

}  // namespace sightline::dds
