/// What is found of a fleet before a flight: of each robot by its link, of its poses, and of all together.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bridges/dds/link_end.hpp"
#include "bridges/dds/surroundings.hpp"
#include "bridges/dds/tag_subscriber.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline::dds {

/// Clocks that differ by more are told apart [s].
inline constexpr double clocks_apart = 0.03;

struct ExaminedRobot {
  std::string name;
  const Link* link;
  LinkEnd* end;
  const TagSubscriber* tags = nullptr;  ///< that robots see who are localized by view; none: nobody is
};

/// All of them, robot by robot, then those of the fleet. By the one thread that looks at the ends; it allocates.
std::vector<Finding> examine_fleet(const Scenario& scenario, std::span<const ExaminedRobot> robots,
                                   const Surroundings& around);

}  // namespace sightline::dds
