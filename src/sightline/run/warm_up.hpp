/// Solvers that run once before each period for the caches, which other programs use while the loop
/// sleeps.
#pragma once

#include <algorithm>
#include <cstdint>

#include "sightline/base/now.hpp"
#include "sightline/loop.hpp"

namespace sightline {

class WarmUp {
 public:
  /// @param budget  longest time before a period [s]; 0: none
  explicit WarmUp(double budget) noexcept : budget_(budget) {}

  /// Calls warm() shortly before period k begins, if there is time. If it takes longer than the
  /// budget, only each 128th period tries again.
  template <class Warm>
  void before(Clock& clock, std::int64_t k, Warm&& warm) noexcept {
    constexpr std::int64_t tries_each = 128;
    constexpr double waking = 1e-4;  // [s]
    if (budget_ <= 0 || (takes_ > budget_ && k % tries_each != 0)) return;
    if (!clock.wait_before(k, std::min(budget_, waking + 2 * takes_))) return;
    const std::int64_t begin = monotonic_now();
    warm();
    takes_ = to_seconds(monotonic_now() - begin);
  }

 private:
  double budget_, takes_ = 0.0;  // [s]
};

}  // namespace sightline
