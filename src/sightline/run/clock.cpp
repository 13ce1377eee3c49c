#include <algorithm>
#include <cmath>

#include "sightline/base/now.hpp"
#include "sightline/loop.hpp"

namespace sightline {

void SteadyClock::start(double period) noexcept {
  period_ns_ = std::max<std::int64_t>(1, to_nanoseconds(period));
  start_ns_ = next_multiple(monotonic_now(), period_ns_);
}

std::int64_t SteadyClock::wait(std::int64_t k) noexcept {
  sleep_until(start_ns_ + k * period_ns_);
  return std::max(k, (monotonic_now() - start_ns_) / period_ns_);
}

bool SteadyClock::wait_before(std::int64_t k, double ahead) noexcept {
  const std::int64_t until = start_ns_ + k * period_ns_ - to_nanoseconds(ahead);
  if (monotonic_now() > until) return false;
  sleep_until(until);
  return true;
}

}  // namespace sightline
