/// One flyer for each robot.
#pragma once

#include <vector>

#include "bridges/dds/domain.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline::dds {

/// Refuses a fleet of whose robots one is told what to do by another program already. To be asked before anything is made that
/// writes to them: a second flyer then leaves the first one's flight alone. Waits for 1 s, in which programs find each other; two that
/// begin at the same time both see nobody here, and are kept from arming by their links.
/// @throws std::runtime_error  agent.NAME: ...
void refuse_second_flyer(const Scenario& scenario, const Domain& domain);

}  // namespace sightline::dds
