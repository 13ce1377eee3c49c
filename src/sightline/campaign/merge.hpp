/// One table of the shards of a campaign.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sightline/scenario/scenario_text.hpp"

namespace sightline {

/// What a table says of its campaign.
struct CampaignWords {
  std::string scenario;    ///< its name
  std::string text;        ///< of the scenario
  FileTexts files;         ///< that it names
  std::string plan;        ///< text of the scenario that draws, where that is another; else empty
  std::uint64_t seed = 0;  ///< of all draws
  int runs = 0, recovered = 0;
};

/// @throws std::invalid_argument with a sentence where the file is no campaign
CampaignWords campaign_words(const std::filesystem::path& file);

/// Writes the table that one process would have left, byte for byte.
/// @param shards  campaign.sqlite of each shard, in any order
/// @param whole   the table, written once all is known to be sound; one that is there must be of this campaign, and no shard
/// @throws std::invalid_argument with a sentence that names the file where one is missing, damaged, not of this campaign, not
///         whole, or there twice, and the shards that lack
/// @throws std::runtime_error where the table cannot be written
void merge_shards(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& whole);

}  // namespace sightline
