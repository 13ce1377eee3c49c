/// The nearest command that keeps linear conditions:
///
///   min |u - u_nom|^2   subject to   a_i . u >= b_i,   u_min <= u <= u_max
///
/// exactly, by the dual active set of Goldfarb and Idnani (1983): from u_nom the most violated condition is taken
/// in, and one whose multiplier turns negative let go, so each step is the optimum for its set and the distance
/// only grows; it ends at the optimum, or with the proof that there is none.
///
/// Where there is none, the rows come in two priorities. The hard ones are kept, and the largest violation
/// max_i (b_i - a_i . u) of the others is made least; of all such u the nearest is taken. Where the hard rows alone
/// contradict each other or the limits, their largest violation is made least first, and the others have what that
/// leaves. It is the same method with one more variable, a slack s common to the rows that may be missed, which costs
/// slack_weight s^2: the largest violation is least up to about 1 / slack_weight.
#pragma once

#include <array>
#include <span>

namespace sightline {

/// One condition a . u >= b; entries of `a` beyond the number of inputs are zero.
struct HalfSpace {
  std::array<double, 4> a{};
  double b = 0.0;
  bool hard = false;  ///< kept before the rows that are not
};

struct ProjectionResult {
  bool feasible = true;    ///< all rows and limits are kept
  double violation = 0.0;  ///< largest b - a . u of all rows; 0 where feasible
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
