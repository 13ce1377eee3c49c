/// The reference's heading as a plan sees it: at most 120 degrees from the robot's own.
///
/// The cost of a heading vector is 2 q (1 - cos e), e the angle from the robot's heading to the reference's. Its slope
/// 2 q sin e is zero at 180 degrees: a plan that begins there stays there. So a solver sees a reference that is turned
/// towards the robot's heading until e is 120 degrees, and where e is less nothing changes, not a bit. As the robot
/// turns, the reference it sees turns ahead of it. docs/equations.md, 6.
///
///   d*_seen = R(delta) d*,   delta = e_seen - e,   e_seen = e           for |e| <= 120 degrees
///                                                  e_seen = 120         for e > 120 and e < -175
///                                                  e_seen = -120        for -175 <= e < -120
///
/// From 120 to 185 degrees the robot turns left, so that rounding and noise do not choose the side at 180. At 185 both
/// ways lead off that angle: the side is chosen once. Along the horizon delta stays what it is at the first
/// stage, and a moving reference moves on; where the reference itself jumps by more than 120 degrees, it is seen 120 degrees
/// from where it was seen before.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "sightline/base/fixed.hpp"

namespace sightline {

class Model;

/// From one heading to another, to the left, in (-175, 185] degrees [rad]: at 180, and where rounding or noise could choose
/// the side, it is to the left.
double heading_error(const Vec2<double>& from, const Vec2<double>& to) noexcept;

/// Of one robot. Without a heading vector among the states that has a weight, it changes nothing.
class HeadingErrorLimit {
 public:
  /// Set-up: allocates.
  /// @param Q, Q_f  weights of the states (nx); Q_f may be empty: 0
  HeadingErrorLimit(const Model& model, std::span<const double> Q, std::span<const double> Q_f);

  /// Whether the states hold a heading vector that has a weight.
  bool applies() const noexcept { return at_[0] >= 0; }

  /// Whether the reference of one stage is too far off to be seen as it is; false where a number is not finite, or a heading is
  /// (0, 0).
  /// @param x      the robot's state; entry i at x[i entry]
  /// @param x_ref  likewise
  bool exceeded(const double* x, const double* x_ref, std::ptrdiff_t entry) const noexcept;

  /// Turns the headings of a reference along the horizon, in place; their lengths stay.
  /// @param x      the robot's state now; entry i at x[i x_entry]
  /// @param x_ref  the reference; entry i of stage k, k = 0 .. n - 1, at x_ref[k stage + i entry]
  /// @return whether any was turned
  bool operator()(const double* x, std::ptrdiff_t x_entry, double* x_ref, int n, std::ptrdiff_t stage,
                  std::ptrdiff_t entry) const noexcept;

 private:
  Vec2<double> heading(const double* x, std::ptrdiff_t entry) const noexcept {
    return {x[at_[0] * entry], x[at_[1] * entry]};
  }

  std::array<std::ptrdiff_t, 2> at_;  // of the heading in the state; -1: none
};

}  // namespace sightline
