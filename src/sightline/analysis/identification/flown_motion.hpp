/// How one multirotor was commanded and how it moved, period by period: what a model of it is fitted to.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "sightline/ocp/team.hpp"
#include "sightline/record/recorded_flight.hpp"
#include "sightline/world/flight_controller.hpp"

namespace sightline {

/// What is seen of a multirotor, in V where that says more than G.
struct SeenMotion {
  Vec3<double> p{};             ///< [m]
  double psi = 0.0;             ///< [rad], unwrapped
  double v_f = 0.0, v_s = 0.0;  ///< forward and to the left [m/s]
  double before = 0.0;          ///< how long before the period of its row it was so [s]; less than a period
};

/// In a straight line from one to the other, the share of 1 of the way.
SeenMotion between(const SeenMotion& from, const SeenMotion& to, double share);

/// Rows are periods from the first to the last; those that were missed have the commands that went on.
struct FlownMotion {
  std::string robot;                       ///< its name
  std::string model;                       ///< of its robot in the scenario
  Commands commands = Commands::tilt;      ///< what its inputs ask for
  std::array<double, 4> u_max{};           ///< limits of u_f, u_s, u_z, u_psi
  double period = 0.01;                    ///< [s]
  std::vector<std::array<double, 4>> u{};  ///< in force from that period on
  std::vector<SeenMotion> measured{};      ///< not a number where nothing was
  std::vector<SeenMotion> truth{};         ///< empty where nobody knows it

  std::size_t size() const { return u.size(); }
  double seconds() const { return period * static_cast<double>(size()); }
  /// Whether it was measured between periods, as over a link: then the vehicle has periods of its own, and when in them a command acts
  /// is not known.
  bool is_between_periods() const;

  /// One more period; what is not known of the truth is an empty span. A measurement stands in the first period after it was so.
  /// @param age  of the measurement [s]; infinite: none
  void add(const Model& of, const double* state, double age, const double* true_state,
           const std::array<double, 4>& command);
};

/// Whether anything was seen.
bool is_seen(const SeenMotion& motion);

/// The robot of that name as one that can be identified; where the name is empty, the only one there is.
/// @throws std::invalid_argument for a name that is none, for a robot that is no multirotor, and for a team of several without a
/// name: "--agent = uav7, expected one of ..."
AgentId identified_robot(const Team& team, const std::string& name);

/// An empty record of that robot.
FlownMotion motion_of(const Team& team, AgentId robot, double period);
/// What a log has of it.
/// @throws std::invalid_argument as identified_robot()
FlownMotion motion_of(const RecordedFlight& flight, double period, const std::string& robot);

}  // namespace sightline
