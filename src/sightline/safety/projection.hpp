/// The nearest command that satisfies linear conditions, by quadratic programming:
///
///   min |u - u_nom|^2   subject to   a_i . u >= b_i,   u_min <= u <= u_max
///
/// The solution is exact, by the dual active-set method of Goldfarb and Idnani (1983). From u_nom,
/// each step adds the most violated condition, and removes conditions whose multipliers turn
/// negative. Each step is the optimum for its active set, and the distance only grows. The method
/// ends at the optimum, or with the proof that no solution exists.
///
/// If no solution exists, the rows have two priorities. The hard rows are kept, and the largest
/// violation max_i (b_i - a_i . u) of the others is minimised; of all such u the nearest is taken.
/// If the hard rows alone contradict each other or the limits, their largest violation is minimised
/// first, and the others receive the remaining freedom. The method is the same with one more
/// variable, a slack s common to all soft rows, at a cost of slack_weight s^2. The largest
/// violation is minimal up to about 1 / slack_weight.
#pragma once

#include <array>
#include <span>

namespace sightline {

/// One condition a . u >= b; entries of `a` beyond the number of inputs are zero.
struct HalfSpace {
  std::array<double, 4> a{};
  double b = 0.0;
  bool hard = false;  ///< has priority over rows that are not hard
};

struct ProjectionResult {
  bool feasible = true;    ///< all rows and limits are kept
  double violation = 0.0;  ///< largest b - a . u of all rows; 0 where feasible
  int steps = 0;           ///< conditions added or removed
};

inline constexpr int most_inputs = 4;
inline constexpr int most_half_spaces = 56;
inline constexpr double slack_weight = 1e8;
/// A row counts as kept if it is missed by at most this times |a|.
inline constexpr double projection_tolerance = 1e-11;

/// @param u_min, u_max  limits, u_min <= u_max
/// @param rows  at most most_half_spaces, finite
/// @param u  in: u_nom, finite; out: the nearest command, exactly within the limits
ProjectionResult project(std::span<const HalfSpace> rows, std::span<const double> u_min,
                         std::span<const double> u_max, std::span<double> u) noexcept;

}  // namespace sightline
