/// Merges the tables of a campaign's shards into one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

/// Description of a campaign in its table.
struct CampaignWords {
  std::string scenario;    ///< its name
  std::string text;        ///< text of the scenario
  FileTexts files;         ///< texts of the files that the scenario names
  std::string plan;        ///< text of the scenario with the draws, if it is another one; else empty
  std::uint64_t seed = 0;  ///< of all draws
  int runs = 0, recovered = 0;
};

/// @throws std::invalid_argument with a sentence if the file is no campaign
CampaignWords campaign_words(const std::filesystem::path& file);

/// Writes the table that a single process would produce, byte for byte.
/// @param shards  campaign.sqlite of each shard, in any order
/// @param whole  the merged table, written after all checks. An existing file must be of this
///   campaign and no shard
/// @throws std::invalid_argument with a sentence that names the file or the missing shards, if a
///   file is missing, damaged, incomplete, duplicate, or of another campaign
/// @throws std::runtime_error if the table cannot be written
void merge_shards(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& whole);

}  // namespace sightline
