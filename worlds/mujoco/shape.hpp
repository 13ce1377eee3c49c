/// A body of an MJCF as a vehicle: mass, inertia and shape.
#pragma once

#include <array>
#include <vector>

#include "sightline/vehicle.hpp"

namespace sightline::mujoco {

/// A contact geom, in the axes of the vehicle, about its centre of mass.
struct Geom {
  int type = 0;                  ///< mjtGeom
  std::array<double, 3> size{};  ///< as MJCF defines it for the type [m]
  std::array<double, 3> p{};     ///< [m]
  std::array<double, 4> q{1, 0, 0, 0};
  std::vector<float> vertices{};  ///< of a mesh, three numbers each [m]
};

struct Shape {
  double mass = 0.0;       ///< [kg]
  Vec3<double> inertia{};  ///< about the centre of mass [kg m^2]
  std::vector<Geom> geoms{};
};

/// The body with all its descendants, in the file's initial configuration.
/// @throws std::invalid_argument "model = ..." or "body = ..."
Shape shape_of(const ModelBody& model);

/// The geoms of a vehicle without a file: a cylinder about p, and one to stand on.
Geom hull_of(const Vehicle& vehicle);
Geom foot_of(const Vehicle& vehicle);

}  // namespace sightline::mujoco
