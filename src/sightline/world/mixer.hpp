/// Mixer: distributes a thrust and a torque over the rotors, with priorities at saturation.
#pragma once

#include <array>

#include "sightline/vehicle.hpp"

namespace sightline {

/// Thrust of each rotor [N]; 0 beyond the vehicle's number of rotors.
using Thrusts = std::array<double, rotors_max>;

/// Least-norm thrusts for the torque M_B, by the pseudo-inverse of the torque map, plus the
/// collective, equal on all rotors:
///
///   M_x = sum y f,   M_y = -sum x f,   M_z = -sum spin k_m f
///
/// Each thrust is between 0 and the rotor's maximum. Tilt has priority: M_x and M_y are scaled only
/// if they alone exceed that range. The collective shifts to make room for them; M_z receives the
/// remainder.
class Mixer {
 public:
  explicit Mixer(const Vehicle& vehicle);

  /// @param thrust  of all rotors [N]
  /// @param torque  about the centre of mass, in B [N m]
  Thrusts operator()(double thrust, const Vec3<double>& torque) const noexcept;

  /// Whether the rotors can produce a torque about each axis. Requires lists of equal length, at
  /// most rotors_max.
  static bool steers(const Vehicle& vehicle);

 private:
  std::size_t rotors_;
  double top_;                                        // maximum thrust of a rotor [N]
  std::array<Vec3<double>, rotors_max> of_torque_{};  // thrust for 1 N m about x, y, z [1/m]
};

}  // namespace sightline
