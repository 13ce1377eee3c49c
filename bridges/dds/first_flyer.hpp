/// Guard against a second flyer program for the same robot.
#pragma once

#include <vector>

#include "bridges/dds/domain.hpp"
#include "sightline/scenario.hpp"

namespace sightline::dds {

/// Throws if another program already commands a robot of the fleet. Call it before any writer
/// exists, so that a second flyer cannot disturb the first one's flight.
/// Waits 1 s for discovery. Two programs that start at the same time do not discover each other
/// here; their links then prevent arming.
/// @throws std::runtime_error  agent.NAME: ...
void refuse_second_flyer(const Scenario& scenario, const Domain& domain);

}  // namespace sightline::dds
