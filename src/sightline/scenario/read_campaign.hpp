/// Reads [campaign] of a scenario.
#pragma once

#include <string>

#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"
#include "sightline/team.hpp"

namespace sightline {

struct ScenarioSpec;
struct ScenarioChanges;

/// Reads [campaign] into the scenario that was read from the document. An invalid [campaign] only
/// sets campaign_refusal, since other flights do not need it.
/// @param text  as written in the file; a campaign draws its numbers
void read_campaign(const TomlDocument& document, const std::string& text, const ScenarioChanges& changes,
                   ScenarioSpec& scenario);

/// [campaign.evasion].
/// @throws ScenarioError
EvasionPlan read_evasion(const TomlTable& at, const Team& team);

}  // namespace sightline
