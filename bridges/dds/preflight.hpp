/// Take-off clearance of a fleet, from the findings before a flight.
#pragma once

#include <string>
#include <vector>

#include "bridges/dds/fleet_findings.hpp"
#include "bridges/dds/topics/seen_bodies.hpp"
#include "bridges/dds/topics/surroundings.hpp"

namespace sightline::dds {

/// Single thread; allocates.
class Preflight {
 public:
  /// @param robots    their ends, the scenario and the bodies must outlive this
  /// @param listened  minimum observation of a robot before its findings count [s]
  /// @throws std::runtime_error if the domain's writers cannot be read
  Preflight(const Scenario& scenario, std::vector<ExaminedRobot> robots, const SeenBodies& bodies,
            dds_entity_t participant, double listened);

  /// Current findings: of each robot, of the fleet, of other bodies.
  std::vector<Finding> examine();
  /// Clears the robots that no finding keeps on the ground.
  void clear();
  bool is_clear(std::size_t robot) const { return robots_[robot].clear; }
  bool all_clear() const;
  /// Reasons that keep the fleet on the ground, one sentence each.
  std::vector<std::string> refusals();

 private:
  struct Robot {
    bool clear = false;
    Nanoseconds received = 0;  // arrival of its first pose, monotonic clock; 0: none yet
  };

  const Scenario& scenario_;
  std::vector<ExaminedRobot> examined_;
  std::vector<Robot> robots_;  // in the order of examined_
  const SeenBodies& bodies_;
  DiscoveryMonitor discovery_;
  Nanoseconds listened_;
};

}  // namespace sightline::dds
