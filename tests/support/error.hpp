/// How far two numbers are apart: the measures that all tests share.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

namespace sightline {

/// |a - b| / max(|a|, |b|, scale); infinite where either is not finite.
inline double relative_error(double a, double b, double scale = 1.0) {
  if (!std::isfinite(a) || !std::isfinite(b)) return std::numeric_limits<double>::infinity();
  return std::fabs(a - b) / std::max({std::fabs(a), std::fabs(b), scale});
}

/// max |a_i - b_i| of two lists of one length.
inline double largest_difference(std::span<const double> a, std::span<const double> b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::fabs(a[i] - b[i]));
  return most;
}

/// |a - exact| in units of the last place of a double at `exact`.
inline double ulps(double a, long double exact) {
  const double near = std::fabs(static_cast<double>(exact));
  const double unit = std::nextafter(near, std::numeric_limits<double>::infinity()) - near;
  return static_cast<double>(std::fabs(static_cast<long double>(a) - exact) / static_cast<long double>(unit));
}

/// The same 64 bits; all that is not a number counts as one.
inline bool same_bits(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) ||
         std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace sightline
