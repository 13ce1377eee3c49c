/// Between what a robot does and the state of its planning model; and what its inputs ask of an autopilot.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bridges/dds/conversion.hpp"
#include "sightline/model/model.hpp"
#include "sightline/model/state_roles.hpp"

namespace sightline::dds {

/// A point of the trajectory that a robot is to follow, in G.
struct TrajectoryPoint {
  Vec3<double> p{}, v{}, a{}, j{};  ///< position [m], velocity, acceleration and its rate
  Vec2<double> d{1, 0};             ///< heading
  double r = 0.0;                   ///< its rate, anticlockwise [rad/s]
};

/// What a robot is to do next, in G.
struct Command {
  Vec3<double> v{};  ///< velocity a moment later [m/s]
  Vec3<double> a{};  ///< mean acceleration until then [m/s^2]
  Vec3<double> p{};  ///< position then [m]
  Vec2<double> d{1, 0};
  double r = 0.0;             ///< rate of the heading then, anticlockwise [rad/s]
  Vec3<double> v_end{};       ///< the velocity that the model would end at, where it would at one [m/s]
  TrajectoryPoint lead{};     ///< now, of the trajectory that the commands so far lead along
  std::array<double, 4> u{};  ///< the first inputs themselves
};

/// Of one robot. After construction nothing allocates, locks or throws; one thread.
class RobotState {
 public:
  static constexpr double ahead = 0.05;  ///< a moment, of Command [s]
  static constexpr double lead_p = 0.5, lead_v = 1.0, lead_d = 0.5;

  /// @throws std::invalid_argument for a model with a state that nobody measures: neither position, heading, velocity nor rate of the heading
  explicit RobotState(const Model& model);

  /// The state of a robot that does so. States that say the same leave no choice; velocities are those along which the model moves.
  /// @param x  (nx)
  void write(const Motion& motion, double* x) noexcept;
  /// The velocity of the model `ahead` later under u, and what leads there. The trajectory goes on by `period`, as the model does under u;
  /// it begins at x, and stays within lead_p of it [m], lead_v [m/s] and lead_d [rad], so that it waits for a robot that cannot follow.
  Command command(const double* x, const double* u, double period) noexcept;
  /// The trajectory begins anew at the next command.
  void rest() noexcept { leads_ = false; }
  /// What the model shows at x under u, and the rate of its heading.
  Motion motion(const double* x, const double* u) noexcept;

 private:
  double heading_rate(const double* x, const double* u) noexcept;
  Vec3<double> end_velocity(const double* x, const double* u) noexcept;
  TrajectoryPoint lead(const double* x, const double* u, double period) noexcept;

  Model model_;
  StateRoles roles_;
  int rate_ = -1;  // the state that is the rate of the heading
  std::vector<double> rest_, scratch_, rates_, faster_;
  std::vector<double> lead_;  // the state of the trajectory's point
  bool leads_ = false;
};

}  // namespace sightline::dds
