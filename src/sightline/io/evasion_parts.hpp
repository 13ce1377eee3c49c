/// [campaign.evasion] of a scenario.
#pragma once

#include "sightline/io/campaign_plan.hpp"
#include "sightline/io/toml_table.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// @throws ScenarioError
EvasionPlan read_evasion(const TomlTable& at, const Team& team);

}  // namespace sightline
