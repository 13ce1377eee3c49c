#include "sightline/run/clock.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

constexpr std::int64_t second = 1'000'000'000;  // [ns]

std::int64_t now_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * second + t.tv_nsec;
}

}  // namespace

void SteadyClock::start(double period) noexcept {
  period_ns_ = std::max<std::int64_t>(1, std::llround(period * static_cast<double>(second)));
  start_ns_ = now_ns();
}

std::int64_t SteadyClock::wait(std::int64_t k) noexcept {
  const std::int64_t begin = start_ns_ + k * period_ns_;
  const timespec wake = {begin / second, begin % second};
  // A signal may end the sleep early; it does not move the grid.
  while (now_ns() < begin) ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
  return std::max(k, (now_ns() - start_ns_) / period_ns_);
}

}  // namespace sightline
