#include "bridges/dds/topics/latency_monitor.hpp"

#include <algorithm>
#include <vector>

#include "sightline/base/now.hpp"
#include "sightline/base/quantile.hpp"

namespace sightline::dds {
namespace {

struct Arrived {
  Nanoseconds at, delay, late;
};

}  // namespace

ArrivalFigures LatencyMonitor::figures(Nanoseconds now, Nanoseconds real_ahead) const {
  const std::uint64_t end = count_.load(std::memory_order_acquire);
  // The writer may overwrite the oldest slots during the copy, so 64 are left out.
  const std::uint64_t kept = std::min<std::uint64_t>(end, places - 64);
  std::vector<Arrived> all;
  for (std::uint64_t i = end - kept; i < end; ++i) {
    const Arrived one = {arrived_[i % places].load(std::memory_order_relaxed),
                         delay_[i % places].load(std::memory_order_relaxed) + real_ahead,
                         late_[i % places].load(std::memory_order_relaxed)};
    if (now - one.at < window) all.push_back(one);
  }
  ArrivalFigures figures;
  if (all.empty()) return figures;
  figures.count = static_cast<std::int64_t>(all.size());
  figures.age = to_seconds(now - all.back().at);
  std::vector<double> gaps, delays, late;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i > 0) gaps.push_back(to_seconds(all[i].at - all[i - 1].at));
    delays.push_back(to_seconds(all[i].delay));
    if (all[i].late >= 0) late.push_back(to_seconds(all[i].late));
  }
  figures.delay_median = quantile(delays, 0.5);
  figures.delay_least = quantile(delays, 0.0);
  if (!late.empty()) figures.late_median = quantile(late, 0.5), figures.late_p99 = quantile(late, 0.99);
  const Nanoseconds span = all.back().at - all.front().at;
  if (span > 0) figures.rate = static_cast<double>(gaps.size()) / to_seconds(span);
  gaps.push_back(figures.age);
  figures.gap_longest = quantile(gaps, 1.0);
  return figures;
}

}  // namespace sightline::dds
