/// Roles of a robot's states and inputs, determined from its formulas.
#pragma once

#include <array>
#include <vector>

namespace sightline {

class Model;

/// Indices into the state; -1 if no state has the role.
struct StateRoles {
  std::array<int, 3> position = {-1, -1, -1};    ///< p_x, p_y, p_z, up to contributions of other states [m]
  std::array<int, 2> direction = {-1, -1};       ///< the heading (d_x, d_y)
  int angle = -1;                                ///< the heading psi [rad]
  std::vector<int> velocities{};                 ///< 1 m/s of each changes the robot's speed by 1 m/s;
                                                 ///< ascending
  std::array<int, 3> velocity_G = {-1, -1, -1};  ///< of `velocities`: along the axes of G
  std::array<int, 2> velocity_V = {-1, -1};      ///< of `velocities`: along the heading, to its left
  int rate = -1;                                 ///< rate of the heading [rad/s]
  std::array<int, 2> tilt = {-1, -1};            ///< proportional to the tilt, forward and to the left
  std::vector<int> others{};                     ///< states without a role

  bool has_position() const { return position[0] >= 0 || position[1] >= 0 || position[2] >= 0; }
  bool has_heading() const { return direction[0] >= 0 || angle >= 0; }
};

/// Roles from the gradients of the symbolic pose and velocity at a few states; names are not used.
/// Allocates: call only during set-up.
StateRoles roles_of(const Model& model);

/// Whether the robot can change its height. True if the vertical velocity depends on a state or an
/// input, or is not 0 at rest. False for a ground robot. Allocates: call only during set-up.
bool has_height(const Model& model);

/// The input that the yaw rate depends on, directly or through the fewest states. -1 if there is
/// none, or several (the wheels of a differential drive). Names are not used. Allocates: call only
/// during set-up.
int yaw_input(const Model& model);

/// Whether an acceleration in G, such as wind, changes the rate of its state. Allocates: call only
/// during set-up.
bool takes_push(const Model& model);

}  // namespace sightline
