/// What each rotor of a vehicle has to lift for a thrust and a torque, where all of it cannot be had.
#pragma once

#include <array>

#include "sightline/world/vehicle.hpp"

namespace sightline {

/// Thrust of each rotor [N]; those beyond the vehicle's are 0.
using Thrusts = std::array<double, rotors_max>;

/// The least thrusts that give the torque M_B, by the pseudo-inverse of what the rotors do, and the collective, equal on all:
///
///   M_x = sum y f,   M_y = -sum x f,   M_z = -sum spin k_m f
///
/// Rotors push between 0 and their greatest thrust. Tilt goes first: M_x and M_y are kept, scaled only where they alone
/// exceed that range; the collective moves to make room for them; M_z gets what is left.
class Mixer {
 public:
  explicit Mixer(const Vehicle& vehicle);

  /// @param thrust  of all rotors [N]
  /// @param torque  about the centre, in B [N m]
  Thrusts operator()(double thrust, const Vec3<double>& torque) const noexcept;

  /// Whether the rotors have a torque about each axis; their lists have one length, within rotors_max.
  static bool steers(const Vehicle& vehicle);

 private:
  std::size_t rotors_;
  double top_;                                        // greatest thrust of a rotor [N]
  std::array<Vec3<double>, rotors_max> of_torque_{};  // thrust for 1 N m about x, y, z [1/m]
};

}  // namespace sightline
