/// What the states of a robot are, found from the pose and the velocity that it shows.
#pragma once

#include <array>
#include <vector>

namespace sightline {

class Model;

/// Indices into the state; -1 where no state is that.
struct StateRoles {
  std::array<int, 3> position = {-1, -1, -1};  ///< p_x, p_y, p_z but for what other states add [m]
  std::array<int, 2> direction = {-1, -1};     ///< the heading (d_x, d_y)
  int angle = -1;                              ///< the heading psi [rad]
  std::vector<int> velocities{};               ///< by 1 m/s each moves the robot 1 m/s faster, rising

  bool has_position() const { return position[0] >= 0 || position[1] >= 0 || position[2] >= 0; }
  bool has_heading() const { return direction[0] >= 0 || angle >= 0; }
};

/// From the gradients of the recorded pose and velocity at a few states; names are not asked, but for a state
/// called v_..., which is a velocity. Set-up: allocates.
StateRoles roles_of(const Model& model);

}  // namespace sightline
