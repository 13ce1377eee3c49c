/// Searches for poses and times at which a potential is not finite, before a flight.
#pragma once

#include <optional>
#include <string>

#include "sightline/potential/potential.hpp"

namespace sightline {

/// What a potential sees at one time.
struct Spot {
  Sight<double> observer, target;
  double t = 0.0;                       ///< [s]
  std::optional<double> ends{};         ///< there it is finite from the beginning on until this time [s]
  std::optional<Vec3<double>> third{};  ///< where the third body is [m], of one that looks past it
};

/// Where and when to search.
struct FiniteSearch {
  double from = 0.0, until = 100.0;  ///< [s]
  double period = 0.0;               ///< every multiple of it is looked at where the time counts [s]; 0: none
  Vec3<double> centre{};             ///< half of the places are around it, half around the origin [m]
  int samples = 20'000;
};

/// A spot where the value, a gradient or a curvature is not finite, of those that are tried: bodies up to
/// 30 m apart, and on top of each other, in line and on the axes. None is no proof. Set-up: allocates.
std::optional<Spot> not_finite_at(const Potential& potential, const FiniteSearch& search = {});

/// "observer at (1, 2, 3) m heading (1, 0), target at ..., t = 0 s", and until when it is finite there.
std::string to_string(const Spot& spot);

}  // namespace sightline
