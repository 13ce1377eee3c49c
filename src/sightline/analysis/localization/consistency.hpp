/// Statistics of estimates against the truth.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

/// Quantile of chi^2 / k with k degrees of freedom, by Wilson and Hilferty; z of the normal one.
inline double scaled_chi_squared(double k, double z) {
  const double root = 1 - 2 / (9 * k) + z * sqrt(2 / (9 * k));
  return std::max(0.0, root) * square(root);
}

/// Bounds of the mean of `independent` normalised errors squared with k components, 95 %.
inline std::array<double, 2> anees_bounds(double k, double independent) {
  return {k * scaled_chi_squared(k * independent, -1.96), k * scaled_chi_squared(k * independent, 1.96)};
}

/// Number of independent values with the variance of the mean of a sequence.
inline double independent_values(const std::vector<double>& x) {
  const auto n = static_cast<double>(x.size());
  if (x.size() < 2) return n;
  double mean = 0.0, variance = 0.0;
  for (const double v : x) mean += v / n;
  for (const double v : x) variance += square(v - mean) / n;
  if (!(variance > 0)) return n;
  double sum = 1.0;
  for (std::size_t lag = 1; lag < x.size() / 4; ++lag) {
    double product = 0.0;
    for (std::size_t i = lag; i < x.size(); ++i) product += (x[i] - mean) * (x[i - lag] - mean);
    const double r = product / (n * variance);
    if (r <= 0.05) break;
    sum += 2 * r;
  }
  return std::max(1.0, n / sum);
}

}  // namespace sightline
