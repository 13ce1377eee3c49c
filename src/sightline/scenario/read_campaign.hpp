/// [campaign] of a scenario.
#pragma once

#include <string>

#include "sightline/ocp/team.hpp"
#include "sightline/scenario/campaign_plan.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

struct Scenario;
struct ScenarioChanges;

/// Puts [campaign] into the scenario that was read from the document: its plan, or why it cannot be flown, since a flight that is
/// no campaign's does not need it.
/// @param text  as it is written, whose numbers a campaign draws
void read_campaign(const TomlDocument& document, const std::string& text, const ScenarioChanges& changes,
                   Scenario& scenario);

/// [campaign.evasion].
/// @throws ScenarioError
EvasionPlan read_evasion(const TomlTable& at, const Team& team);

}  // namespace sightline
