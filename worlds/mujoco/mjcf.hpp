/// The MJCF of a team: the model that MuJoCo simulates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/team.hpp"
#include "worlds/mujoco/shape.hpp"

namespace sightline::mujoco {

/// The bits of geoms define three kinds of contact. MuJoCo pairs two geoms if the contype of one
/// meets the conaffinity of the other.
///
///   outer geom of a vehicle with another one, or a point body   detected, but without force: the gap
///                                                               is beyond any depth
///   solid geom of a vehicle with the ground or surroundings     MuJoCo's contact forces
///   all other pairs of a team                                   none
///
/// Only pairs of vehicles near each other therefore cost time.
inline constexpr int outer_bit = 1 << 30, solid_bits = outer_bit - 1;

/// The name of the plane z = 0.
inline constexpr const char* ground = "the ground";

/// The geoms of a vehicle: `outer` to other bodies, `solid` to the ground and the surroundings.
struct Geoms {
  std::vector<Geom> outer, solid;
};

/// A model that consists of one included file.
std::string included(const ModelFile& file);

/// Bodies come last in the model, in the order of the team: vehicles are free bodies, all others
/// are mocap points.
/// @param geoms  of each vehicle
std::string mjcf_of(const Team& team, const std::vector<RobotVehicle>& vehicles,
                    const std::vector<Geoms>& geoms, const std::optional<ModelFile>& surroundings);

}  // namespace sightline::mujoco
