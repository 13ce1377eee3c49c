/// DDS bridge for robots of PX4 and ROS 2. Link sightline::dds.
///
///   Registry registry;
///   add_dds(registry);                                  // sightline fly, sightline vehicles
///   return command_line(argc, argv, registry);
#pragma once

#include "sightline/registry.hpp"

namespace sightline {

/// Registers DDS as the bridge for fleets.
/// @throws std::invalid_argument if a bridge is registered already
void add_dds(Registry& registry);

}  // namespace sightline
