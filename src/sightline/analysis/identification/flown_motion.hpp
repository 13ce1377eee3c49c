/// Commands and motion of one multirotor, period by period: the data of a model fit.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/team.hpp"
#include "sightline/world/flight_controller.hpp"

namespace sightline {

/// Measured motion of a multirotor; the velocity is in V.
struct SeenMotion {
  Vec3<double> p{};             ///< [m]
  double psi = 0.0;             ///< [rad], unwrapped
  double v_f = 0.0, v_s = 0.0;  ///< forward and to the left [m/s]
  double before = 0.0;  ///< time from the measurement to the period of its row [s], less than a period
};

/// Linear interpolation; `share` 0 gives `from`, 1 gives `to`.
SeenMotion between(const SeenMotion& from, const SeenMotion& to, double share);

/// Rows are periods from the first to the last. Missed periods hold the commands that stayed in
/// force.
struct FlownMotion {
  std::string robot;                       ///< its name
  std::string model;                       ///< kind of the robot in the scenario
  Commands commands = Commands::tilt;      ///< kind of its inputs
  std::array<double, 4> u_max{};           ///< limits of u_f, u_s, u_z, u_psi
  double period = 0.01;                    ///< [s]
  std::vector<std::array<double, 4>> u{};  ///< in force from that period on
  std::vector<SeenMotion> measured{};      ///< NaN if nothing was measured
  std::vector<SeenMotion> truth{};         ///< empty if unknown

  std::size_t size() const { return u.size(); }
  double seconds() const { return period * static_cast<double>(size()); }
  /// Whether the measurements lie between periods, as over a link. Then the vehicle has periods of
  /// its own, and the time at which a command acts is unknown.
  bool is_between_periods() const;

  /// Appends a period. A measurement belongs to the first period after its time.
  /// @param age  of the measurement [s]; infinite: none
  /// @param true_state  null if unknown
  void add(const Model& of, const double* state, double age, const double* true_state,
           const std::array<double, 4>& command);
};

/// Whether the motion was measured, i.e. is finite.
bool is_seen(const SeenMotion& motion);

/// The robot of that name if its model can be identified; for an empty name, the only such robot.
/// @throws std::invalid_argument for an unknown name, for a robot that is no multirotor, and for an
///   empty name in a team without exactly one: "--agent = uav7, expected one of ..."
AgentId identified_robot(const Team& team, const std::string& name);

/// An empty record of that robot.
FlownMotion motion_of(const Team& team, AgentId robot, double period);
/// The record of that robot in a log.
/// @throws std::invalid_argument as identified_robot()
FlownMotion motion_of(const RecordedFlight& flight, double period, const std::string& robot);

}  // namespace sightline
