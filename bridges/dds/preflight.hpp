/// Who of a fleet may take off: by what is found of it before a flight.
#pragma once

#include <string>
#include <vector>

#include "bridges/dds/fleet_findings.hpp"
#include "bridges/dds/seen_bodies.hpp"
#include "bridges/dds/surroundings.hpp"

namespace sightline::dds {

/// One thread; it allocates.
class Preflight {
 public:
  /// @param robots    whose ends outlive it, as scenario and bodies do
  /// @param listened  to a robot, until what is found of it counts [s]
  /// @throws std::runtime_error where nobody says who is there
  Preflight(const Scenario& scenario, std::vector<ExaminedRobot> robots, const SeenBodies& bodies,
            dds_entity_t participant, double listened);

  /// What is found now: of each robot, of the fleet, of other bodies.
  std::vector<Finding> examine();
  /// Clears those whom nothing that is found keeps on the ground.
  void clear();
  bool is_clear(std::size_t robot) const { return robots_[robot].clear; }
  bool all_clear() const;
  /// What keeps the fleet on the ground, a sentence each.
  std::vector<std::string> refusals();

 private:
  struct Robot {
    bool clear = false;
    Nanoseconds received = 0;  // when its first pose was there, of the monotonic clock; 0: none was
  };

  const Scenario& scenario_;
  std::vector<ExaminedRobot> examined_;
  std::vector<Robot> robots_;  // in their order
  const SeenBodies& bodies_;
  DiscoveryMonitor discovery_;
  Nanoseconds listened_;
};

}  // namespace sightline::dds
