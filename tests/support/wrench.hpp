/// What thrusts of its rotors do to a vehicle.
#pragma once

#include "sightline/world/mixer.hpp"

namespace sightline::test {

struct RotorWrench {
  double thrust = 0.0;    ///< [N]
  Vec3<double> torque{};  ///< [N m]
};

inline RotorWrench wrench(const Vehicle& v, const Thrusts& f) {
  RotorWrench w;
  for (std::size_t i = 0; i < v.rotors(); ++i) {
    w.thrust += f[i];
    w.torque = w.torque + f[i] * Vec3<double>{v.rotor_y[i], -v.rotor_x[i], -v.spin[i] * v.k_m};
  }
  return w;
}

}  // namespace sightline::test
