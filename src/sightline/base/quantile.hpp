/// Quantiles of a list, and of a stream of any length.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace sightline {

/// The smallest value that at least a fraction q in [0, 1] of the values does not exceed. q = 0.5
/// gives the median, the lower of the two in the middle. Without values the result is NaN.
inline double quantile(std::vector<double> values, double q) {
  assert(q >= 0 && q <= 1 && "a quantile is a share");
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size())));
  const std::size_t place = std::clamp<std::size_t>(rank, 1, values.size()) - 1;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Quantiles of a stream in bounded memory, at most 0.6 MB. Mean and extremes are exact. Quantiles
/// are exact for the first `exact_max` numbers; for more, within 0.5 % of numbers from 1e-6 to
/// 1e12. Smaller numbers count as the smallest received, larger ones as the greatest.
class Quantiles {
 public:
  static constexpr std::size_t exact_max = 65'536;

  /// Reserves memory for `count` numbers in advance, up to the bound.
  void reserve(std::size_t count) { first_.reserve(std::min(count, exact_max)); }

  void add(double value) {
    sum_ += value;
    least_ = std::min(least_, value);
    greatest_ = std::max(greatest_, value);
    ++count_;
    if (count_ <= exact_max) return first_.push_back(value);
    if (bins_.empty()) {
      bins_.resize(bins);
      for (const double one : first_) ++bins_[bin_of(one)];
    }
    ++bins_[bin_of(value)];
  }

  std::uint64_t count() const { return count_; }
  /// NaN without numbers, as is greatest().
  double mean() const { return sum_ / static_cast<double>(count_); }
  double greatest() const { return count_ > 0 ? greatest_ : std::numeric_limits<double>::quiet_NaN(); }
  /// As the function quantile().
  double quantile(double q) const {
    assert(q >= 0 && q <= 1 && "a quantile is a share");
    if (bins_.empty()) return sightline::quantile(first_, q);
    const double rank = std::max(1.0, std::ceil(q * static_cast<double>(count_)));
    double up_to = 0.0;
    for (std::size_t bin = 0; bin < bins; ++bin) {
      up_to += static_cast<double>(bins_[bin]);
      if (up_to < rank) continue;
      const double middle = lowest * std::exp((static_cast<double>(bin) - 0.5) * log_ratio);
      return bin == 0 ? least_ : bin == bins - 1 ? greatest_ : std::clamp(middle, least_, greatest_);
    }
    return greatest_;
  }

 private:
  // Bin i > 0 counts numbers between lowest * ratio^(i - 1) and lowest * ratio^i, ratio = 1.01.
  static constexpr double lowest = 1e-6, log_ratio = 0.009950330853168083;
  static constexpr std::size_t bins = 4200;

  static std::size_t bin_of(double value) {
    if (!(value > lowest)) return 0;
    return static_cast<std::size_t>(std::min(std::log(value / lowest) / log_ratio + 1.0, bins - 1.0));
  }

  std::vector<double> first_;
  std::vector<std::uint64_t> bins_;  // of all numbers, once there are more than exact_max
  double sum_ = 0.0, least_ = std::numeric_limits<double>::infinity(), greatest_ = -least_;
  std::uint64_t count_ = 0;
};

}  // namespace sightline
