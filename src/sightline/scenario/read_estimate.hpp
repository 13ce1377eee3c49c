/// Reads localization, observes and estimate of [agent.NAME], and [estimate] of all robots.
#pragma once

#include <string>
#include <vector>

#include "sightline/estimate/observability.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"
#include "sightline/worlds.hpp"

namespace sightline {

/// Fills scenario.localization and scenario.radio. Requires all bodies, couplings and events.
void read_estimates(const TomlTable& root, ScenarioSpec& scenario);

/// How a robot is localized by vision; nullptr: its own state is measured.
const LocalizedRobot* localized_robot(const ScenarioSpec& scenario, BodyId body);

/// What the sensors of a team measure, for unobservable_states().
struct SensedTeam {
  std::vector<SensingRobot>
      robots{};  ///< all bodies; of vision-localized robots, the states that their own sensors measure
  std::vector<PlacedRobot> places{};  ///< at the start
  std::vector<Sees> sightings{};      ///< of vision-localized robots
};
SensedTeam sensed_team(const ScenarioSpec& scenario);
/// Whether the cameras of an observer measure the headings of bodies with tags.
bool sees_headings(const ScenarioSpec& scenario, BodyId observer);

/// Poses that robots and bodies report in simulation.
TelemetryOptions telemetry_options(const ScenarioSpec& scenario);

/// "localized   uav0: by view of uav1, ...", a line for each vision-localized robot.
std::string localization_words(const ScenarioSpec& scenario);

}  // namespace sightline
