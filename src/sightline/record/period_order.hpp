/// Whether the periods of a log follow each other.
#pragma once

#include <cstdint>
#include <map>
#include <utility>

namespace sightline {

/// Counts periods from 0 on. Allocates where the loop missed some.
class PeriodOrder {
 public:
  /// The loop missed `count` periods before this one, and said so.
  void miss(std::int64_t before, std::int64_t count) { missed_[before] += count; }

  /// Takes the next period, once all that was missed before it is known.
  /// @return whether it follows the last one, but for those that the loop missed
  bool follows(std::int64_t period) {
    const auto missed = missed_.find(period);
    const std::int64_t gap = period - std::exchange(next_, period + 1);
    return gap == (missed != missed_.end() ? missed->second : 0);
  }
  std::int64_t next() const { return next_; }  ///< behind the last one

 private:
  std::map<std::int64_t, std::int64_t> missed_;
  std::int64_t next_ = 0;
};

}  // namespace sightline
