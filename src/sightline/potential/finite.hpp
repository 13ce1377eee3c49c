/// Search, before a flight, for poses and times at which a potential is not finite.
#pragma once

#include <optional>
#include <string>

#include "sightline/potential.hpp"

namespace sightline {

/// Arguments of a potential at one time.
struct Spot {
  Sight<double> observer, target;
  double t = 0.0;                       ///< [s]
  std::optional<double> ends{};         ///< at these poses it is finite from the start of the search until
                                        ///< this time [s]
  std::optional<Vec3<double>> third{};  ///< position of the third body [m], if the potential uses one
};

/// Range of the search.
struct FiniteSearch {
  double from = 0.0, until = 100.0;  ///< [s]
  double period = 0.0;               ///< grid of the times to test, if the potential depends on time [s]; 0:
                                     ///< none
  Vec3<double> centre{};             ///< half of the positions are around it, half around the origin [m]
  int samples = 20'000;
};

/// Returns the first sampled spot at which the value, a gradient or a curvature is not finite.
/// Samples have bodies up to 30 m apart, coincident, aligned and on the axes. An empty result is no
/// proof. Allocates: call only during set-up.
std::optional<Spot> not_finite_at(const Potential& potential, const FiniteSearch& search = {});

/// Description, "observer at (1, 2, 3) m heading (1, 0), target at ..., t = 0 s", with the time
/// until which it is finite there.
std::string to_string(const Spot& spot);

}  // namespace sightline
