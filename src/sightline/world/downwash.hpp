/// Downwash: the air that a vehicle accelerates downward onto vehicles below it.
#pragma once

#include <string_view>

#include "sightline/base/fixed.hpp"
#include "sightline/base/parameter.hpp"

namespace sightline {

/// Downwash parameters of a vehicle world.
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

/// Mean flow below the rotors of one vehicle, modelled as one disc of radius R. It is that of
/// momentum theory at the disc and a turbulent round jet far below. At depth z along the jet and
/// distance r off its axis,
///
///   w = sqrt(2 F / (pi rho)) / b  e^{-r^2 / b^2},
///   F = T / 2 (1 + zeta),   b^2 = 2 R^2 / (1 + zeta) + (growth z)^2,   zeta = z / sqrt(R^2 + z^2)
///
/// F is the momentum flux, rho times the integral of w^2 over a cross section at any z. F is T / 2
/// at the disc, where pressure carries the other half, and T far below. The speed on the axis is
/// v_i = sqrt(T / (2 rho pi R^2)) at the disc and approaches 2 v_i. Where the jet has grown, it
/// decays as 1 / z. Above the disc the air is at rest.
///
/// The jet follows the thrust without delay and stays straight: wind and ground do not bend it.
/// Sources: docs/vehicles.md.
struct Jet {
  static constexpr double air_density = 1.225;  ///< rho [kg/m^3]
  static constexpr double growth = 0.113;       ///< of the radius b at which the speed is 1/e, over z

  Vec3<double> p{};             ///< centre of the disc, in G [m]
  Vec3<double> down{0, 0, -1};  ///< opposite to the thrust, |down| = 1
  double thrust = 0.0;          ///< T [N], >= 0
  double radius2 = 1.0;         ///< R^2 [m^2], > 0

  /// Velocity in G of the jet's air at the point `there` [m/s]; 0 if a number is not finite.
  Vec3<double> air(const Vec3<double>& there) const noexcept;
};

}  // namespace sightline
