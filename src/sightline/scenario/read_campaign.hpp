/// [campaign] of a scenario.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/ocp/team.hpp"
#include "sightline/scenario/campaign_plan.hpp"
#include "sightline/scenario/scenario_numbers.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// @param document  holds [campaign]
/// @param numbers   of the scenario, of which it draws some
/// @param try_set   reads the scenario with numbers that it does not write set, "KEY=VALUE", and throws ScenarioError where it
///                  refuses them
/// @throws ScenarioError
CampaignPlan read_campaign(const TomlDocument& document, ScenarioNumbers numbers, const Team& team,
                           const std::function<void(const std::vector<std::string>& set)>& try_set);

/// [campaign.evasion].
/// @throws ScenarioError
EvasionPlan read_evasion(const TomlTable& at, const Team& team);

}  // namespace sightline
