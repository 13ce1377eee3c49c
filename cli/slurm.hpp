/// A campaign as an array of jobs of Slurm, a shard each.
#pragma once

#include <filesystem>
#include <string>

#include "cli/commands.hpp"

namespace sightline::cli {

/// Where a shard flies.
std::filesystem::path shard_folder(const std::filesystem::path& folder, int shard);

/// The script of the array, as sbatch takes it: task I flies shard I of all into shard_folder(folder, I).
std::string slurm_script(const CampaignCommand& command, std::uint64_t seed, const std::string& name,
                         const std::filesystem::path& folder);

/// Submits it, waits until none of its tasks is left, and says which shards failed and why.
/// @return whether all shards are there
/// @throws std::runtime_error where Slurm does not take it
bool fly_by_slurm(const std::string& script, int shards, const std::filesystem::path& folder);

}  // namespace sightline::cli
