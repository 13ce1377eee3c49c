/// Between what a robot does and the state of its planning model; and what its inputs ask of an autopilot.
#pragma once

#include <string>
#include <vector>

#include "bridges/dds/conversion.hpp"
#include "sightline/model/model.hpp"
#include "sightline/model/state_roles.hpp"

namespace sightline::dds {

/// What a robot is to do next, in G.
struct Command {
  Vec3<double> v{};  ///< velocity a moment later [m/s]
  Vec3<double> a{};  ///< mean acceleration until then [m/s^2]
  Vec3<double> p{};  ///< position then [m]
  Vec2<double> d{1, 0};
  double r = 0.0;        ///< rate of the heading then, anticlockwise [rad/s]
  Vec3<double> v_end{};  ///< the velocity that the model would end at, where it would at one [m/s]
};

/// Of one robot. After construction nothing allocates, locks or throws; one thread.
class RobotState {
 public:
  static constexpr double ahead = 0.05;  ///< a moment, of Command [s]

  /// @throws std::invalid_argument for a model with a state that nobody measures: neither position, heading, velocity nor rate of the heading
  explicit RobotState(const Model& model);

  /// The state of a robot that does so. States that say the same leave no choice; velocities are those along which the model moves.
  /// @param x  (nx)
  void write(const Motion& motion, double* x) noexcept;
  /// The velocity of the model `ahead` later under u, and what leads there.
  Command command(const double* x, const double* u) noexcept;
  /// What the model shows at x under u, and the rate of its heading.
  Motion motion(const double* x, const double* u) noexcept;

 private:
  double heading_rate(const double* x, const double* u) noexcept;
  Vec3<double> end_velocity(const double* x, const double* u) noexcept;

  Model model_;
  StateRoles roles_;
  int rate_ = -1;  // the state that is the rate of the heading
  std::vector<double> rest_, scratch_, rates_, faster_;
};

}  // namespace sightline::dds
