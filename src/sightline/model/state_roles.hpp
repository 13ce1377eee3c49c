/// What the states and inputs of a robot are, found from its formulas.
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

/// From the gradients of the recorded pose and velocity at a few states; names play no part. Set-up: allocates.
StateRoles roles_of(const Model& model);

/// Whether anything can change its height: a state or an input that the vertical velocity depends on, or one that is
/// not 0 at rest. A robot that drives on the ground has none. Set-up: allocates.
bool has_height(const Model& model);

/// The input that the yaw rate follows, at once or through the fewest states; -1 where none does, or where several do
/// (the wheels of a differential drive). Names play no part. Set-up: allocates.
int yaw_input(const Model& model);

/// Whether an acceleration of G, as wind gives it, changes the rate of its state. Set-up: allocates.
bool takes_push(const Model& model);

}  // namespace sightline
