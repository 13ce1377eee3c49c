/// [campaign] of a scenario.
#pragma once

#include "sightline/io/campaign_plan.hpp"
#include "sightline/io/toml_table.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// @param document  holds [campaign], and the numbers that it draws
/// @throws ScenarioError
CampaignPlan read_campaign(const TomlDocument& document, const Team& team);

}  // namespace sightline
