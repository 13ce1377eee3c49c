/// Part of campaign.html: how the first runs evaded their obstacle.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sightline/campaign/evasion.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

inline constexpr int evasion_runs_max = 10;  // the paper's number of runs

/// Flies the first runs of a campaign again with an EvasionTrace, at most evasion_runs_max.
/// @param scenario  its text is the template of the runs
/// @throws std::invalid_argument if its bodies are not those of plan.evasion
EvasionRuns evasion_runs(const Scenario& scenario, const CampaignPlan& plan, std::uint64_t seed, int runs);

/// Table 1 as text: a line for each quantity and source.
std::string evasion_text(const EvasionPlan& plan, std::span<const EvasionRuns> flown);

/// Table 1 and the figures of each scenario, as a part of a page.
/// @throws std::runtime_error with a sentence if a figure cannot be drawn
std::string evasion_html(const EvasionPlan& plan, std::span<const EvasionRuns> flown);

}  // namespace sightline
