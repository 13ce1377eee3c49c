/// The inputs of the last seconds, for predictions from old measurements.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace sightline {

/// A ring buffer of inputs, each in force until the next. Its size is fixed.
class InputHistory {
 public:
  /// @param entries  capacity, >= 1
  /// @param initial  input in force before the first record (nu)
  InputHistory(std::size_t entries, std::span<const double> initial)
      : nu_(initial.size()), times_(entries), rows_(entries * initial.size()) {
    assert(entries > 0 && "a history holds something");
    times_[0] = -std::numeric_limits<double>::infinity();
    std::copy(initial.begin(), initial.end(), rows_.begin());
  }

  /// Records that u (nu) is in force from t [s] on; t must rise.
  void record(double t, std::span<const double> u) noexcept {
    newest_ = (newest_ + 1) % times_.size();
    count_ = std::min(count_ + 1, times_.size());
    times_[newest_] = t;
    std::copy(u.begin(), u.end(), rows_.begin() + static_cast<std::ptrdiff_t>(newest_ * nu_));
  }

  /// Calls piece(from, to, u) for each interval of [from, to) [s] with constant input. Before the
  /// oldest stored entry, the oldest entry counts.
  template <class Piece>
  void visit(double from, double to, Piece&& piece) const {
    std::size_t back = 0;
    while (back + 1 < count_ && time(back) > from) ++back;
    for (double t = from; t < to;) {
      const double until = back > 0 ? std::min(time(back - 1), to) : to;
      if (until > t) piece(t, until, row(back));
      t = std::max(t, until);
      if (back > 0) --back;
    }
  }

 private:
  std::size_t at(std::size_t back) const noexcept { return (newest_ + times_.size() - back) % times_.size(); }
  double time(std::size_t back) const noexcept { return times_[at(back)]; }
  std::span<const double> row(std::size_t back) const noexcept {
    return std::span(rows_).subspan(at(back) * nu_, nu_);
  }

  std::size_t nu_, newest_ = 0, count_ = 1;
  std::vector<double> times_, rows_;
};

}  // namespace sightline
