/// A campaign of short flights: the shipped scenario, all that it draws, a second of each.
#pragma once

#include "sightline/analysis.hpp"

namespace sightline {

inline Scenario small_campaign() {
  Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml",
                                    built_in_registry(), {"simulation.rms_from=0.5"});
  scenario.campaign->duration = 1.0;
  return scenario;
}

}  // namespace sightline
