/// campaign.html: a campaign's table in figures.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/campaign/runs.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Page of the first table, compared with the other tables, which flew the same draws.
/// @param command  shell command that flies a run again, without `--only INDEX -o DIR`
/// @param folder  parent of the folders run_INDEX of such runs
/// @param more  HTML inserted before the worst runs
/// @throws std::runtime_error with a sentence if a table cannot be read or a figure cannot be drawn
std::string campaign_html(const std::vector<CampaignTable>& tables, const CampaignPlan& plan,
                          const std::string& command, const std::filesystem::path& folder,
                          const std::string& more = {});

/// A text as one word of a shell command, quoted if necessary.
std::string shell_word(std::string_view text);

/// A line of the campaign's summary.
struct CampaignLine {
  std::string what, value;
};

/// Summary of a campaign: outcomes with their bounds, times, distances and energies.
std::vector<CampaignLine> campaign_lines(const CampaignTable& table);

}  // namespace sightline
