/// The air that vehicles push down, and that moves around those below.
#pragma once

#include <string_view>

#include "sightline/base/fixed.hpp"
#include "sightline/base/parameter.hpp"

namespace sightline {

/// What a world of vehicles is told of it.
struct DownwashOptions {
  static constexpr std::string_view name = "world";

  double scale = 0.0;

  static constexpr auto parameters() {
    return std::tuple{parameter("downwash", &DownwashOptions::scale, "", Bounds{0.0, 2.0, "0 to 2"},
                                "speed of the air under vehicles, over that of momentum theory; 0: still")};
  }

  /// @throws std::invalid_argument naming the parameter, its value and its range
  void check() const { check_parameters(*this); }
};

/// The mean flow under the rotors of one vehicle, all as one disc of radius R: momentum theory at the disc, a turbulent round jet far
/// below. At z along the jet from the disc, r off its axis,
///
///   w = sqrt(2 F / (pi rho)) / b  e^{-r^2 / b^2},
///   F = T / 2 (1 + zeta),   b^2 = 2 R^2 / (1 + zeta) + (growth z)^2,   zeta = z / sqrt(R^2 + z^2)
///
/// F is the flux of momentum, rho times the integral of w^2 over a section, whatever z: T / 2 at the disc, where pressure carries the
/// other half, and T below. The speed on the axis is v_i = sqrt(T / (2 rho pi R^2)) at the disc, goes towards 2 v_i and, where the jet
/// has grown, falls with 1 / z. Nothing moves above the disc.
///
/// The jet follows the thrust at once and goes straight along it: no wind bends it, and no ground.
/// Sources: docs/vehicles.md.
struct Jet {
  static constexpr double air_density = 1.225;  ///< rho [kg/m^3]
  static constexpr double growth = 0.113;       ///< of the radius b at which the speed is 1/e, over z

  Vec3<double> p{};             ///< centre of the disc, in G [m]
  Vec3<double> down{0, 0, -1};  ///< against the thrust, |down| = 1
  double thrust = 0.0;          ///< T [N], >= 0
  double radius2 = 1.0;         ///< R^2 [m^2], > 0

  /// Velocity of its air there, in G [m/s]; 0 where a number is not finite.
  Vec3<double> air(const Vec3<double>& there) const noexcept;
};

}  // namespace sightline
