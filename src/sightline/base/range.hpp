/// Numbers that a key of a scenario takes.
#pragma once

#include <cmath>
#include <limits>
#include <string_view>

namespace sightline {

/// Which numbers a key takes, and the words for it: "> 0 s".
struct Range {
  double low, high;           // both are allowed
  std::string_view expected;  // ends with the unit
};

/// Nothing a scenario measures is larger; beyond it squares and sixth powers are no longer safe.
inline constexpr double largest_number = 1e9;

constexpr Range any_number(std::string_view expected = "finite, at most 1e9 either way") {
  return {-largest_number, largest_number, expected};
}
constexpr Range not_negative(std::string_view expected) { return {0.0, largest_number, expected}; }
constexpr Range positive(std::string_view expected) {
  return {std::numeric_limits<double>::min(), largest_number, expected};
}

inline constexpr Range time_range = not_negative(">= 0 s");

/// Finite, not negative.
inline bool at_least_zero(double value) { return value >= 0 && std::isfinite(value); }

}  // namespace sightline
