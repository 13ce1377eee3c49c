#include "bridges/dds/topics/latency_monitor.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "sightline/base/quantile.hpp"

namespace sightline::dds {
namespace {

constexpr Nanoseconds drift_from = 4'000'000'000;

double seconds_of(Nanoseconds t) { return 1e-9 * static_cast<double>(t); }

struct Arrived {
  Nanoseconds at, delay;
};

/// The arrival with the least delay.
Arrived fastest_of(const Arrived* begin, const Arrived* end) {
  return *std::min_element(begin, end, [](const Arrived& a, const Arrived& b) { return a.delay < b.delay; });
}

}  // namespace

ArrivalFigures LatencyMonitor::figures(Nanoseconds now, Nanoseconds real_ahead) const {
  const std::uint64_t end = count_.load(std::memory_order_acquire);
  // The writer may overwrite the oldest slots during the copy, so 64 are left out.
  const std::uint64_t kept = std::min<std::uint64_t>(end, places - 64);
  std::vector<Arrived> all;
  for (std::uint64_t i = end - kept; i < end; ++i) {
    const Arrived one = {arrived_[i % places].load(std::memory_order_relaxed),
                         delay_[i % places].load(std::memory_order_relaxed) + real_ahead};
    if (now - one.at < window) all.push_back(one);
  }
  ArrivalFigures figures;
  if (all.empty()) return figures;
  const Arrived* const first = all.data();
  const Arrived* const last = first + all.size();
  figures.count = static_cast<std::int64_t>(all.size());
  figures.age = seconds_of(now - all.back().at);
  std::vector<double> gaps, delays;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i > 0) gaps.push_back(seconds_of(all[i].at - all[i - 1].at));
    delays.push_back(seconds_of(all[i].delay));
  }
  figures.delay_median = quantile(delays, 0.5);
  figures.delay_p99 = quantile(delays, 0.99);
  figures.delay_least = seconds_of(fastest_of(first, last).delay);
  const Nanoseconds span = all.back().at - all.front().at;
  if (span > 0) figures.rate = static_cast<double>(gaps.size()) / seconds_of(span);
  gaps.push_back(figures.age);
  figures.gap_longest = quantile(gaps, 1.0);
  if (span >= drift_from) {
    const Arrived* const middle =
        std::find_if(first, last, [&](const Arrived& one) { return one.at >= all.front().at + span / 2; });
    const Arrived before = fastest_of(first, middle), after = fastest_of(middle, last);
    if (after.at > before.at) figures.drift = seconds_of(after.delay - before.delay) / seconds_of(span / 2);
  }
  return figures;
}

}  // namespace sightline::dds
