/// Robots over DDS, as PX4 and ROS 2 speak it. Link sightline::dds.
///
///   Parts parts;
///   add_dds(parts);                                  // sightline fly, sightline vehicles
///   return command_line(argc, argv, parts);
#pragma once

#include "sightline/scenario/parts.hpp"

namespace sightline {

/// Makes it the bridge that fleets are flown by.
/// @throws std::invalid_argument where there is one already
void add_dds(Parts& parts);

}  // namespace sightline
