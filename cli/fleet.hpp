/// Functions common to the commands for fleets.
#pragma once

#include <atomic>

#include "bridges/dds/fleet/bridge.hpp"
#include "cli/commands.hpp"
#include "sightline/registry.hpp"

namespace sightline::cli {

/// Reads a scenario with a [fleet], for a program with a bridge.
/// @throws std::invalid_argument if the scenario has no [fleet] or the program no bridge
Scenario read_fleet(const NamedScenario& fleet, const Registry& registry);

/// @throws std::invalid_argument if the program has no bridge
void refuse_without_bridge(const Registry& registry);
/// Prints the robots' counts and faults of the flight; returns whether there are faults.
bool say_end(const LinkedWorld& world);

/// Number of requests to end this program, from listen_to_interrupts() on.
Interrupts& interrupts();
/// True after the first request.
std::atomic<bool>& stop_flight();
void listen_to_interrupts();

}  // namespace sightline::cli
