#include "sightline/server/paced_clock.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base/now.hpp"

namespace sightline {
namespace {

constexpr std::int64_t one_nap = 20'000'000;  // [ns]

}  // namespace

PacedClock::PacedClock(double speed, bool paused, const std::atomic<bool>& stop)
    : speed_(speed), paused_(paused), stop_(stop) {}

void PacedClock::start(double period) noexcept {
  period_ns_ = std::max<std::int64_t>(1, to_nanoseconds(period / speed_));
  next_ns_ = monotonic_now();
}

std::int64_t PacedClock::wait(std::int64_t k) noexcept {
  if (!paused_) steps_ = 0;
  while (k > 0 && paused_ && !stop_) {
    if (steps_ > 0) {
      --steps_;
      break;
    }
    sleep_until(monotonic_now() + one_nap);
    next_ns_ = monotonic_now();
  }
  while (monotonic_now() < next_ns_ && !stop_) sleep_until(std::min(next_ns_, monotonic_now() + one_nap));
  next_ns_ = std::max(next_ns_ + period_ns_, monotonic_now());
  return k;
}

}  // namespace sightline
