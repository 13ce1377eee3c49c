/// Ranges of the numbers that scenario keys accept.
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <string_view>

namespace sightline {

/// A range of numbers and its description: "> 0 s".
struct Range {
  double low, high;           // both are included
  std::string_view expected;  // ends with the unit

  /// False for NaN.
  constexpr bool holds(double value) const { return value >= low && value <= high; }
  /// The description, plus the bound that the value violates if the description omits it: "> 0 m,
  /// at most 1e9".
  std::string expected_of(double value) const;
};

/// Largest number of a scenario; beyond it squares and sixth powers may overflow.
inline constexpr double largest_number = 1e9;

constexpr Range any_number(std::string_view expected = "finite, at most 1e9 either way") {
  return {-largest_number, largest_number, expected};
}
constexpr Range not_negative(std::string_view expected) { return {0.0, largest_number, expected}; }
constexpr Range positive(std::string_view expected) {
  return {std::numeric_limits<double>::min(), largest_number, expected};
}

inline constexpr Range time_range = not_negative(">= 0 s");

inline std::string Range::expected_of(double value) const {
  std::string words(expected);
  if (words.find("at most 1e9") != std::string::npos) return words;
  if (value > high && high == largest_number) words += ", at most 1e9";
  if (value < low && low == -largest_number) words += ", at least -1e9";
  if (value > 0 && value < low && low == std::numeric_limits<double>::min()) words += ", at least 2.3e-308";
  return words;
}

/// Finite, not negative.
inline bool at_least_zero(double value) { return value >= 0 && std::isfinite(value); }

}  // namespace sightline
