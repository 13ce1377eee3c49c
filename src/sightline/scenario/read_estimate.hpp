/// How robots know where they are: [agent.NAME] localized_by, watches and estimate, and [estimate] of all of them.
#pragma once

#include <string>

#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"
#include "sightline/world/telemetry_world.hpp"

namespace sightline {

/// Fills scenario.localization and scenario.radio; after all bodies, couplings and events.
void read_estimates(const TomlTable& root, Scenario& scenario);

/// What robots and bodies tell in simulation.
TelemetryOptions telemetry_options(const Scenario& scenario);

/// "localized   uav0: by view of uav1, ...", a line for each robot that is.
std::string localization_words(const Scenario& scenario);

}  // namespace sightline
