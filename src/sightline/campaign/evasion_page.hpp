/// The part of campaign.html that shows how the first runs evaded their obstacle.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sightline/campaign/evasion.hpp"
#include "sightline/scenario/campaign_plan.hpp"

namespace sightline {

inline constexpr int evasion_runs_max = 10;  // the paper's ten

/// The first runs of a campaign, flown once more under an EvasionTrace; at most evasion_runs_max of them.
/// @param scenario  its text is what the campaign's numbers are written over
/// @throws std::invalid_argument where its bodies are not those of plan.evasion
EvasionRuns evasion_runs(const Scenario& scenario, const CampaignPlan& plan, std::uint64_t seed, int runs);

/// Table 1 for a person: a line for each quantity and source.
std::string evasion_text(const EvasionPlan& plan, std::span<const EvasionRuns> flown);

/// Table 1, and the figures of each scenario, as part of a page.
/// @throws std::runtime_error with a sentence where a figure cannot be drawn
std::string evasion_html(const EvasionPlan& plan, std::span<const EvasionRuns> flown);

}  // namespace sightline
