/// campaign.html: what a campaign's table says, in figures.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/campaign/runs.hpp"
#include "sightline/scenario/campaign_plan.hpp"

namespace sightline {

/// The page of the first table; the others, which flew the same draws, stand beside it.
/// @param command  what flies a run again, in words of a shell, but for `--only INDEX -o DIR`
/// @param folder   where such a run goes: run_INDEX within it
/// @param more     a part of the page before the worst runs
/// @throws std::runtime_error with a sentence where a table cannot be read or a figure cannot be drawn
std::string campaign_html(const std::vector<CampaignTable>& tables, const CampaignPlan& plan,
                          const std::string& command, const std::filesystem::path& folder,
                          const std::string& more = {});

/// A text as one word of a shell's command: as it is where a shell leaves it so, else in quotes.
std::string shell_word(std::string_view text);

/// A line of the campaign as a person reads it.
struct CampaignLine {
  std::string what, value;
};

/// The campaign in a few lines: outcomes with their bounds, times, distances and energies.
std::vector<CampaignLine> campaign_lines(const CampaignTable& table);

}  // namespace sightline
