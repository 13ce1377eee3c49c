/// What the commands of fleets have in common.
#pragma once

#include <atomic>

#include "cli/commands.hpp"
#include "sightline/scenario/bridge.hpp"
#include "sightline/scenario/registry.hpp"

namespace sightline::cli {

/// A scenario with a [fleet], for a program that has a bridge.
/// @throws std::invalid_argument for one without, and for a program without
Scenario read_fleet(const NamedScenario& fleet, const Registry& registry);

/// How often a person asked to end this program, from listen_to_interrupts() on.
Interrupts& interrupts();
/// True from the first time on.
std::atomic<bool>& stop_flight();
void listen_to_interrupts();

}  // namespace sightline::cli
