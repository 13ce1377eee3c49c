/// Robots over DDS, as PX4 and ROS 2 speak it. Link sightline::dds.
///
///   Registry registry;
///   add_dds(registry);                                  // sightline fly, sightline vehicles
///   return command_line(argc, argv, registry);
#pragma once

#include "sightline/scenario/registry.hpp"

namespace sightline {

/// Makes it the bridge that fleets are flown by.
/// @throws std::invalid_argument where there is one already
void add_dds(Registry& registry);

}  // namespace sightline
