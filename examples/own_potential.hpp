// A potential of one's own, a template over its scalar; its derivatives are found for it.
#pragma once

#include <sightline/kernels.hpp>

/// Keeps a robot out of the air that another's rotors throw down: a Gaussian column below the other.
///
///   l = kappa_H exp(-((x^2 + y^2) / s_r^2 + (z / s_z)^2) / 2),   (x, y, z) from the other's column to the robot
struct Downwash {
  double kappa_H = 3.0;  ///< height [-]
  double s_r = 0.35;     ///< width of the column [m]
  double s_z = 0.8;      ///< half its height [m]

  static constexpr std::string_view name = "downwash";

  template <class S>
  S operator()(const sightline::Sight<S>& robot, const sightline::Sight<S>& other) const {
    const sightline::Vec3<S> r = robot.p - other.p;
    const S z = r.z + s_z;
    return kappa_H * exp(-0.5 / (s_r * s_r) * (r.x * r.x + r.y * r.y) - 0.5 / (s_z * s_z) * (z * z));
  }
};

/// What `sightline_add_formulas(TARGET own_potential.hpp)` compiles; without that line it is interpreted.
inline void sightline_formulas(sightline::Generator& generator) {
  using namespace sightline;
  generator.add({1.0 * Downwash{}});
}
