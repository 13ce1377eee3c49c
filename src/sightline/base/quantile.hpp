/// Quantiles of numbers.
#pragma once

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace sightline {

/// The least of the values that a share q in [0, 1] of them does not exceed: q = 0.5 gives the median, the lower of the
/// two in the middle. Of no values it is not a number.
inline double quantile(std::vector<double> values, double q) {
  assert(q >= 0 && q <= 1 && "a quantile is a share");
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size())));
  const std::size_t place = std::clamp<std::size_t>(rank, 1, values.size()) - 1;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace sightline
