/// [campaign.evasion] of a scenario.
#pragma once

#include "sightline/ocp/team.hpp"
#include "sightline/scenario/campaign_plan.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// @throws ScenarioError
EvasionPlan read_evasion(const TomlTable& at, const Team& team);

}  // namespace sightline
