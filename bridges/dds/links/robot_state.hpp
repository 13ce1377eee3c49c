/// Conversion between a robot's motion and the state of its planning model, and from planned inputs
/// to autopilot commands.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bridges/dds/topics/conversion.hpp"
#include "sightline/model.hpp"
#include "sightline/model/state_roles.hpp"

namespace sightline::dds {

/// A point of the trajectory that a robot is to follow, in G.
struct TrajectoryPoint {
  Vec3<double> p{}, v{}, a{}, j{};  ///< position [m], velocity [m/s], acceleration [m/s^2], jerk [m/s^3]
  Vec2<double> d{1, 0};             ///< heading, unit vector
  double r = 0.0;                   ///< heading rate, anticlockwise [rad/s]
};

/// Next command of a robot, in G.
struct Command {
  Vec2<double> d{1, 0};       ///< heading after RobotState::ahead
  double r = 0.0;             ///< heading rate then, anticlockwise [rad/s]
  Vec3<double> v_end{};       ///< steady-state velocity of the model, if it has one [m/s]
  TrajectoryPoint lead{};     ///< current point of the trajectory integrated from the commands
  std::array<double, 4> u{};  ///< the first inputs
};

/// State conversion of one robot; single thread. After construction nothing allocates, locks or
/// throws.
class RobotState {
 public:
  static constexpr double ahead = 0.05;  ///< look-ahead time of Command [s]
  static constexpr double lead_p = 0.5, lead_v = 1.0, lead_d = 0.5;

  /// @throws std::invalid_argument if the model has a state that is not measured: neither position,
  ///   heading, velocity nor heading rate
  explicit RobotState(const Model& model);

  /// Writes the model state of a motion. Redundant states are set consistently; each velocity state
  /// is the component of v along its direction of motion.
  /// @param x  (nx)
  void write(const Motion& motion, double* x) noexcept;
  /// Command of the input u. Its trajectory advances by `period` under u, from x at the first call. It stays within lead_p
  /// [m], lead_v [m/s] and lead_d [rad] of the robot, so that it waits for a robot that cannot
  /// follow.
  Command command(const double* x, const double* u, double period) noexcept;
  /// Restarts the trajectory at the next command.
  void rest() noexcept { leads_ = false; }
  /// Motion of the model at x under u, with its heading rate.
  Motion motion(const double* x, const double* u) noexcept;

 private:
  double heading_rate(const double* x, const double* u) noexcept;
  Vec3<double> end_velocity(const double* x, const double* u) noexcept;
  TrajectoryPoint lead(const double* x, const double* u, double period) noexcept;

  Model model_;
  StateRoles roles_;
  std::vector<double> rest_, scratch_, rates_, faster_;
  std::vector<double> lead_;  // state of the trajectory point
  bool leads_ = false;
};

}  // namespace sightline::dds
