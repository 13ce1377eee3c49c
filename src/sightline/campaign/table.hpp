/// campaign.sqlite: the runs of a campaign, a row each.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/campaign/campaign.hpp"
#include "sightline/campaign/database.hpp"

namespace sightline {

/// Writes
///
///   runs      "index", seed, outcome, min_distance, time_to_first_view, fraction_in_view, could_brake, violations,
///             energy, a column status_NAME for each Status, a column for each number drawn, by its name, and
///             ROBOT.energy for each robot
///   campaign  key, value: scenario, text, seed, duration, version, compiler
///
/// Rows come in the order of the index and go to disk every 256 runs, so that equal campaigns give equal bytes,
/// and one that is killed leaves a table that opens.
class RunTable {
 public:
  /// @throws std::runtime_error naming the file, here and below, where it cannot be written
  RunTable(const std::filesystem::path& file, const Scenario& scenario, const CampaignPlan& plan,
           std::uint64_t seed);

  void add(const RunDraw& run, const RunResult& result);
  /// All that was added is on its way to the disk.
  void finish();

 private:
  static constexpr int rows_at_once = 256;
  Database database_;
  std::optional<Database::Statement> insert_;
  int waiting_ = 0;
};

/// What the column of a robot's energy is called, after its name.
inline constexpr std::string_view energy_ending = ".energy";

/// The columns of `runs` that do not depend on what is drawn.
std::vector<std::string> fixed_columns();

}  // namespace sightline
