/// A fault of a controller that a scenario injects: updates that take too long.
#pragma once

#include <limits>

namespace sightline {

/// Delays the controller: an update that begins in from <= t < until takes `delay` to finish. Until
/// then the previous plan stays in force and no other update begins.
struct LatePlan {
  double from = 0.0;
  double until = std::numeric_limits<double>::infinity();
  double delay = 0.1;  ///< [s], in [0, 10]

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
  /// Whether an update that begins at t is late.
  bool strikes(double t) const noexcept;
};

}  // namespace sightline
