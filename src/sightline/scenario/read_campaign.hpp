/// [campaign] of a scenario.
#pragma once

#include "sightline/ocp/team.hpp"
#include "sightline/scenario/campaign_plan.hpp"
#include "sightline/scenario/scenario_numbers.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// @param document  holds [campaign]
/// @param numbers   of the scenario, of which it draws some
/// @throws ScenarioError
CampaignPlan read_campaign(const TomlDocument& document, ScenarioNumbers numbers, const Team& team);

/// [campaign.evasion].
/// @throws ScenarioError
EvasionPlan read_evasion(const TomlTable& at, const Team& team);

}  // namespace sightline
