/// How robots know where they are: [agent.NAME] localization, observes and estimate, and [estimate] of all of them.
#pragma once

#include <string>
#include <vector>

#include "sightline/estimate/observability.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"
#include "sightline/world/telemetry_world.hpp"

namespace sightline {

/// Fills scenario.localization and scenario.radio; after all bodies, couplings and events.
void read_estimates(const TomlTable& root, Scenario& scenario);

/// A team as its sensors determine it, for unobservable_states().
struct SensedTeam {
  std::vector<SensingRobot>
      robots{};  ///< all bodies; of those that are localized by view, what their own sensors tell
  std::vector<PlacedRobot> places{};  ///< at the start
  std::vector<Sees> sightings{};      ///< of those that are localized by view
};
SensedTeam sensed_team(const Scenario& scenario);
/// Whether the camera of an observer tells the headings of bodies with tags.
bool sees_headings(const Scenario& scenario, BodyId observer);

/// What robots and bodies tell in simulation.
TelemetryOptions telemetry_options(const Scenario& scenario);

/// "localized   uav0: by view of uav1, ...", a line for each robot that is.
std::string localization_words(const Scenario& scenario);

}  // namespace sightline
