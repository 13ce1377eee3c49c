/// Checks that the periods of a log are consecutive.
#pragma once

#include <cstdint>
#include <map>
#include <utility>

namespace sightline {

/// Counts periods from 0. Allocates for missed periods.
class PeriodOrder {
 public:
  /// The loop reported `count` missed periods before period `before`.
  void miss(std::int64_t before, std::int64_t count) { missed_[before] += count; }

  /// Adds the next period; all missed periods before it must be known.
  /// @return true if it follows the previous period, not counting the reported missed periods
  bool follows(std::int64_t period) {
    const auto missed = missed_.find(period);
    const std::int64_t gap = period - std::exchange(next_, period + 1);
    return gap == (missed != missed_.end() ? missed->second : 0);
  }
  std::int64_t next() const { return next_; }  ///< one after the last period

 private:
  std::map<std::int64_t, std::int64_t> missed_;
  std::int64_t next_ = 0;
};

}  // namespace sightline
