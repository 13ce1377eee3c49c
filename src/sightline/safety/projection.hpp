/// The nearest command that keeps linear conditions:
///
///   min |u - u_nom|^2   subject to   a_i . u >= b_i,   u_min <= u <= u_max
///
/// exactly, by the dual active set of Goldfarb and Idnani (1983): from u_nom the most violated condition is taken
/// in, and one whose multiplier turns negative let go, so each step is the optimum for its set and the distance
/// only grows; it ends at the optimum, or with the proof that there is none.
///
/// Where there is none, the largest violation max_i (b_i - a_i . u) is made least, and of all such u the nearest
/// is taken: the same method with one more variable, a slack s common to all rows that costs slack_weight s^2.
/// That makes the largest violation least up to about 1 / slack_weight.
#pragma once

#include <array>
#include <span>

namespace sightline {

/// One condition a . u >= b; entries of `a` beyond the number of inputs are zero.
struct HalfSpace {
  std::array<double, 4> a{};
  double b = 0.0;
};

struct ProjectionResult {
  bool feasible = true;    ///< all rows and limits are kept
  double violation = 0.0;  ///< largest b - a . u; 0 where feasible
  int steps = 0;           ///< conditions taken in or let go
};

inline constexpr int most_inputs = 4;
inline constexpr int most_half_spaces = 56;
inline constexpr double slack_weight = 1e8;
/// A row counts as kept if it is missed by no more than this times |a|.
inline constexpr double projection_tolerance = 1e-11;

/// @param u_min, u_max  limits, u_min <= u_max
/// @param rows          at most most_half_spaces, finite
/// @param u             u_nom, finite; then the nearest command, within the limits exactly
ProjectionResult project(std::span<const HalfSpace> rows, std::span<const double> u_min,
                         std::span<const double> u_max, std::span<double> u) noexcept;

}  // namespace sightline
