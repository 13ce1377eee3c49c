/// Findings about a fleet before a flight: per robot by its link and poses, and for all robots
/// together.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bridges/dds/links/link_end.hpp"
#include "bridges/dds/topics/surroundings.hpp"
#include "bridges/dds/topics/tag_subscriber.hpp"
#include "sightline/scenario.hpp"

namespace sightline::dds {

/// Clock differences above this limit are reported [s].
inline constexpr double clocks_apart = 0.03;

struct ExaminedRobot {
  std::string name;
  const Link* link;
  LinkEnd* end;
  const TagSubscriber* tags = nullptr;  ///< tag observations of vision-localized robots; null: there are none
};

/// The place where a robot joins the team: its start, at any height.
struct JoiningPlace {
  static constexpr double beside_most = 0.5;  ///< horizontal distance from the start [m]
  static constexpr double turned_most = 0.5;  ///< from its heading, of a robot with a heading [rad]

  JoiningPlace(const Scenario& scenario, BodyId robot);

  double beside(const Motion& robot) const noexcept;  ///< [m]
  double turned(const Motion& robot) const noexcept;  ///< [rad]; 0 without a heading
  bool holds(const Motion& robot) const noexcept {
    return beside(robot) <= beside_most && turned(robot) <= turned_most;
  }

 private:
  Sight<double> start_;
  bool has_heading_;
};

/// Rate and longest gap of a body's poses, against the supervisor's limits. Few poses of motion
/// capture or /tf give an unknown finding, few of a robot's own odometry none.
void examine_rate(const Scenario& scenario, const PosesFrom& from, const ArrivalFigures& f, FindingList& to);

/// Findings per robot, then those of the fleet. Call it on the one thread that examines the link
/// ends; allocates.
std::vector<Finding> examine_fleet(const Scenario& scenario, std::span<const ExaminedRobot> robots,
                                   const Surroundings& around);

}  // namespace sightline::dds
