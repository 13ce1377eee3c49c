/// campaign.sqlite: the runs of a campaign, a row each.
#pragma once

#include <array>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/service_thread.hpp"
#include "sightline/campaign/campaign.hpp"
#include "sightline/campaign/database.hpp"

namespace sightline {

/// What a table says of its campaign, by key.
using AboutCampaign = std::map<std::string, Database::Value>;

/// Writes
///
///   runs      "index", seed, outcome, reason, min_distance, time_to_first_view, fraction_in_view, could_brake, violations,
///             energy, chatter, drift, longest_without_plan, barrier_conflict, a column status_NAME for each Status, a column for each number drawn, by its name, and
///             the robot_endings of each robot; at last digest, of all that stands before it in the row
///   campaign  key, value: scenario, text, plan (the text of the scenario that draws, where that is another), seed,
///             duration, version, compiler; "file NAME" with the text of each file that the scenario names; of a shard
///             "I/N of RUNS" as shard; at its end a digest of all rows
///
/// Rows come in the order of the index. A thread commits them, each within half a second and the time that takes, so
/// that a campaign that is killed leaves all rows but those of the last second, and can go on. At its end the file is
/// written anew as a whole, so that equal campaigns give equal bytes, however they came about.
class RunTable {
 public:
  /// Goes on with the rows that are there, where they are of this campaign and this binary.
  /// @param runs  of the whole campaign; of a shard alone
  /// @throws std::invalid_argument where the file holds something else, with what
  /// @throws std::runtime_error naming the file, here and below, where it cannot be written
  RunTable(const std::filesystem::path& file, const Scenario& scenario, const CampaignPlan& plan,
           std::uint64_t seed, const Shard& shard = {}, int runs = 0);
  ~RunTable();  ///< Commits what was added.
  RunTable(const RunTable&) = delete;
  RunTable& operator=(const RunTable&) = delete;

  /// Rows that were there: of the shard's runs 0 to rows() - 1.
  int rows() const { return rows_; }
  /// Of them, those of an outcome.
  int rows(Outcome outcome);
  /// Whether the row of a run that was there says the same; before the first add().
  bool holds(const RunDraw& run, const RunResult& result);

  void add(const RunDraw& run, const RunResult& result);
  /// All that was added is in the file, and nothing beside it.
  void finish();

 private:
  using Row = std::vector<Database::Value>;

  void begin(const AboutCampaign& about, const std::string& columns);
  void go_on(const AboutCampaign& about, const std::string& columns);
  void keep_committing(const std::stop_token& stop);
  void commit(std::vector<Row> rows);

  std::filesystem::path file_;
  Shard shard_;
  std::optional<Database> database_;  // of the constructor, then of the thread, then of finish()
  int rows_ = 0;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<Row> waiting_;
  std::exception_ptr failure_;
  bool changes_ = false;
  std::stop_source stop_;
  ServiceThread thread_{"the table of the campaign"};
};

/// Whether the campaign can go on after the rows that are there: the last of them is flown again. Before the first add().
/// @param file  of the table
/// @throws std::invalid_argument where it flies otherwise now, or the table holds more than options.runs
void check_continues(RunTable& table, const std::filesystem::path& file, const Scenario& scenario,
                     const CampaignPlan& plan, const CampaignOptions& options);

/// Of a table that is open.
AboutCampaign about_campaign(Database& database);
/// Makes `campaign` with these words, and `runs` by its statement.
void create_tables(Database& database, const AboutCampaign& about, const std::string& runs);
/// Writes the rows into a new file, whose bytes follow from them alone. Counts as one change of the database.
void write_clean(Database& database, const std::filesystem::path& file);

/// Over all rows in their order: of rows that are not as they were written it is another one.
std::string rows_digest(Database& database);
/// Puts it into `campaign`.
void write_digest(Database& database);
/// The word of `campaign` that tells it, of a table that was written to its end.
inline constexpr std::string_view digest_key = "digest";

/// The word of `campaign` that tells the shard.
inline constexpr std::string_view shard_key = "shard";
/// The column of a row's digest, the last one.
inline constexpr std::string_view row_digest_column = "digest";
/// @throws std::runtime_error naming the first run whose row is not as it was written
void check_rows(Database& database);

/// Of the text of a file that the scenario names, before its name.
inline constexpr std::string_view file_key = "file ";

/// What the columns of a robot's energy and errors are called, after its name.
inline constexpr std::array<std::string_view, 3> robot_endings = {".energy", ".rms_position_error",
                                                                  ".rms_heading_error"};

/// And of the error of its estimate, its consistency and its longest time without sight, where it is localized by vision.
inline constexpr std::array<std::string_view, 3> localization_endings = {".rmse", ".anees",
                                                                         ".longest_without_sight"};

/// The columns of `runs` that do not depend on what is drawn.
std::vector<std::string> fixed_columns();

}  // namespace sightline
