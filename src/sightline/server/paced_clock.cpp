#include "sightline/server/paced_clock.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

constexpr std::int64_t one_second = 1'000'000'000, one_nap = 20'000'000;  // [ns]

std::int64_t paced_now() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * one_second + t.tv_nsec;
}

void sleep_to(std::int64_t time) {
  const timespec wake = {time / one_second, time % one_second};
  ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
}

}  // namespace

PacedClock::PacedClock(double speed, bool paused, const std::atomic<bool>& stop)
    : speed_(speed), paused_(paused), stop_(stop) {}

void PacedClock::start(double period) noexcept {
  period_ns_ = std::max<std::int64_t>(1, std::llround(period / speed_ * static_cast<double>(one_second)));
  next_ns_ = paced_now();
}

std::int64_t PacedClock::wait(std::int64_t k) noexcept {
  if (!paused_) steps_ = 0;
  while (k > 0 && paused_ && !stop_) {
    if (steps_ > 0) {
      --steps_;
      break;
    }
    sleep_to(paced_now() + one_nap);
    next_ns_ = paced_now();
  }
  while (paced_now() < next_ns_ && !stop_) sleep_to(std::min(next_ns_, paced_now() + one_nap));
  next_ns_ = std::max(next_ns_ + period_ns_, paced_now());
  return k;
}

}  // namespace sightline
