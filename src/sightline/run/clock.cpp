#include <algorithm>
#include <cmath>

#include "sightline/base/now.hpp"
#include "sightline/loop.hpp"

namespace sightline {

void SteadyClock::start(double period) noexcept {
  period_ns_ = std::max<std::int64_t>(1, std::llround(1e9 * period));
  start_ns_ = next_multiple(monotonic_now(), period_ns_);
}

std::int64_t SteadyClock::wait(std::int64_t k) noexcept {
  sleep_until(start_ns_ + k * period_ns_);
  return std::max(k, (monotonic_now() - start_ns_) / period_ns_);
}

}  // namespace sightline
