/// A vehicle with six rotors.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/vehicle.hpp"

namespace sightline {

/// An x500 with six rotors on a circle, in turns anticlockwise and clockwise, and half as heavy
/// again.
inline Vehicle hexacopter() {
  Vehicle v = Vehicle::x500();
  v.mass *= 1.5;
  v.rotor_x.clear(), v.rotor_y.clear(), v.spin.clear();
  for (int i = 0; i < 6; ++i) {
    const double angle = (2 * i + 1) * std::numbers::pi / 6;
    v.rotor_x.push_back(0.3 * std::cos(angle));
    v.rotor_y.push_back(0.3 * std::sin(angle));
    v.spin.push_back(i % 2 == 0 ? 1 : -1);
  }
  v.check();
  return v;
}

/// The hexacopter and the vehicles that a scenario may name.
inline std::vector<Vehicle> all_vehicles() {
  std::vector<Vehicle> all = {hexacopter()};
  for (const auto& preset : Vehicle::presets()) all.push_back(preset.part);
  return all;
}

}  // namespace sightline
