/// Looks for places where a potential is no number, before anything flies there.
#pragma once

#include <optional>
#include <string>

#include "sightline/potential/potential.hpp"

namespace sightline {

/// What a potential sees at one time.
struct Spot {
  Sight<double> observer, target;
  double t = 0.0;  ///< [s]
};

/// A spot where the value, a gradient or a curvature is not finite, of `samples` that are tried: bodies up to
/// 30 m apart, and on top of each other, in line and on the axes. None is no proof. Set-up: allocates.
std::optional<Spot> not_finite_at(const Potential& potential, int samples = 20'000);

/// "observer at (1, 2, 3) m heading (1, 0), target at ..., t = 0 s".
std::string to_string(const Spot& spot);

}  // namespace sightline
