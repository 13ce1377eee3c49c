/// A campaign as a Slurm job array with one shard per task.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/commands.hpp"

namespace sightline::cli {

/// Requests of a job array. Empty or 0 leaves the choice to Slurm and to SBATCH_* in the
/// environment.
struct SlurmOptions {
  bool submit = false, dry_run = false;
  int shards = 8, cpus = 0;
  std::string partition{}, time{};
};

struct CampaignCommand {
  NamedScenario scenario;  ///< its `set` applies to the compared scenario too
  std::filesystem::path output, compare_with;
  int runs = 200, threads = 0;  ///< threads: 0 for the number of cores
  std::optional<std::uint64_t> seed;
  std::optional<int> only;
  int certify = 0;  ///< runs of importance sampling of each event; 0: no bounds
  std::string shard;
  bool resume = false;
  std::vector<std::filesystem::path> merge;
  SlurmOptions slurm;
};

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
