/// Limits the heading error of a reference in a plan to 120 degrees from the robot's heading.
///
/// The cost of a heading vector is 2 q (1 - cos e), e the angle from the robot's heading to the
/// reference's. Its slope 2 q sin e is zero at 180 degrees, so a plan that starts there would stay
/// there. The solver therefore receives a reference that is rotated towards the robot's heading
/// until |e| is 120 degrees. Smaller errors are unchanged, bit for bit. As the robot turns, the
/// rotated reference moves ahead of it. docs/equations.md, 6.
///
///   d*_seen = R(delta) d*,   delta = e_seen - e,   e_seen = e           for |e| <= 120 degrees
///                                                  e_seen = 120         for e > 120 and e < -175
///                                                  e_seen = -120        for -175 <= e < -120
///
/// From 120 to 185 degrees the robot turns left, so that rounding and noise do not choose the side
/// at 180. At 185 degrees both directions lead away from that angle, so the side is chosen once.
/// Along the horizon delta keeps its value of the first stage, and a moving reference keeps moving.
/// If the reference itself jumps by more than 120 degrees, it is placed 120 degrees from its
/// previous rotated value.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "sightline/base/fixed.hpp"

namespace sightline {

class Model;

/// Angle from one heading to another, positive to the left, in (-175, 185] degrees [rad]. The range
/// includes 180 degrees and a margin for rounding and noise on the left side.
double heading_error(const Vec2<double>& from, const Vec2<double>& to) noexcept;

/// Heading error limit of one robot. It has no effect unless the states include a heading vector
/// with a weight.
class HeadingErrorLimit {
 public:
  /// Allocates: call only during set-up.
  /// @param Q, Q_f  weights of the states (nx); Q_f may be empty: 0
  HeadingErrorLimit(const Model& model, std::span<const double> Q, std::span<const double> Q_f);

  /// Whether the states include a heading vector with a weight.
  bool applies() const noexcept { return at_[0] >= 0; }

  /// Whether the reference of one stage exceeds the limit; false if a number is not finite or a
  /// heading is (0, 0).
  /// @param x      the robot's state; entry i at x[i entry]
  /// @param x_ref  likewise
  bool exceeded(const double* x, const double* x_ref, std::ptrdiff_t entry) const noexcept;

  /// Rotates the headings of a reference along the horizon, in place; their lengths stay.
  /// @param x      the robot's present state; entry i at x[i x_entry]
  /// @param x_ref  the reference; entry i of stage k, k = 0 .. n - 1, at x_ref[k stage + i entry]
  /// @return whether any heading was rotated
  bool operator()(const double* x, std::ptrdiff_t x_entry, double* x_ref, int n, std::ptrdiff_t stage,
                  std::ptrdiff_t entry) const noexcept;

 private:
  Vec2<double> heading(const double* x, std::ptrdiff_t entry) const noexcept {
    return {x[at_[0] * entry], x[at_[1] * entry]};
  }

  std::array<std::ptrdiff_t, 2> at_;  // indices of the heading in the state; -1: none
};

}  // namespace sightline
