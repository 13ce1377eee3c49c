/// A campaign as a Slurm job array with one shard per task.
#pragma once

#include <filesystem>
#include <string>

#include "cli/commands.hpp"

namespace sightline::cli {

/// Output folder of a shard.
std::filesystem::path shard_folder(const std::filesystem::path& folder, int shard);

/// The script of the array for sbatch: task I flies shard I of all into shard_folder(folder, I).
std::string slurm_script(const CampaignCommand& command, std::uint64_t seed, const std::string& name,
                         const std::filesystem::path& folder);

/// Submits the script, waits until none of its tasks is left, and prints which shards failed and
/// why.
/// @return whether all shards are complete
/// @throws std::runtime_error if Slurm rejects the script
bool fly_by_slurm(const std::string& script, int shards, const std::filesystem::path& folder);

}  // namespace sightline::cli
