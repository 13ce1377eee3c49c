/// The MJCF of a team: what MuJoCo is given to simulate.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/ocp/team.hpp"
#include "worlds/mujoco/shape.hpp"

namespace sightline::mujoco {

/// Contacts are of three kinds, by the bits of geoms (MuJoCo lets two touch where contype of one meets conaffinity of the other):
///
///   outer geom of a vehicle, of another one; point of another body   seen, and carry no force: their gap is beyond any depth
///   solid geom of a vehicle, the ground or the surroundings          with MuJoCo's contact forces
///   all else of a team                                               none
///
/// So no pairs of vehicles but those that come near each other cost anything.
inline constexpr int outer_bit = 1 << 30, solid_bits = outer_bit - 1;

/// The name of the plane z = 0.
inline constexpr const char* ground = "the ground";

/// The geoms of a vehicle: to other bodies, and to the ground and the surroundings.
struct Geoms {
  std::vector<Geom> outer, solid;
};

/// A model that is one file.
std::string included(const ModelFile& file);

/// Bodies come in the order of the team and last in the model: vehicles free, all others points that mocap moves.
/// @param geoms  of each vehicle
std::string mjcf_of(const Team& team, const std::vector<RobotVehicle>& vehicles,
                    const std::vector<Geoms>& geoms, const std::optional<ModelFile>& surroundings);

}  // namespace sightline::mujoco
