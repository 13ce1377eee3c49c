/// campaign.sqlite: the runs of a campaign, one row each.
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

#include "sightline/analysis.hpp"
#include "sightline/base.hpp"
#include "sightline/campaign/database.hpp"

namespace sightline {

/// Description of a campaign in its table, by key.
using AboutCampaign = std::map<std::string, Database::Value>;

/// Writes the tables
///
///   runs      "index", seed, outcome, reason, min_distance, time_to_first_view, fraction_in_view,
///             could_brake, violations, energy, chatter, drift, longest_without_plan,
///             barrier_conflict, longest_out_of_view, view_margin, distance_margin, landed; a column status_NAME for each Status; a column for each drawn
///             number, by its name; the robot_endings of each robot; last, digest: of all earlier
///             columns of the row
///   campaign  key, value: scenario, text, plan (the text of the scenario with the draws, if it is
///             another one), seed, duration, version, compiler; "file NAME" with the text of each
///             file that the scenario names; shard, "I/N of RUNS", for a shard only; after the last
///             row, a digest of all rows
///
/// Rows are in the order of the index. A thread commits waiting rows every half second. A killed
/// campaign thus loses only the rows of about the last second, and can continue. At the end the
/// whole file is rewritten, so that equal campaigns have equal bytes regardless of their history.
class RunTable {
 public:
  /// Continues after the existing rows, if they are of this campaign and this binary.
  /// @param runs  of the whole campaign; only for a shard
  /// @throws std::invalid_argument with the difference, if the file has other content
  /// @throws std::runtime_error naming the file, here and below, if it cannot be written
  RunTable(const std::filesystem::path& file, const Scenario& scenario, const CampaignPlan& plan,
           std::uint64_t seed, const Shard& shard = {}, int runs = 0);
  ~RunTable();  ///< commits the added rows
  RunTable(const RunTable&) = delete;
  RunTable& operator=(const RunTable&) = delete;

  /// Number of existing rows: the shard's runs 0 to rows() - 1.
  int rows() const { return rows_; }
  /// Number of the existing rows with an outcome.
  int rows(Outcome outcome);
  /// Whether the existing row of a run equals the result. Only before the first add().
  bool holds(const RunDraw& run, const RunResult& result);

  void add(const RunDraw& run, const RunResult& result);
  /// Completes the file: all added rows are in it, and no other file remains.
  void finish();

 private:
  using Row = std::vector<Database::Value>;

  void begin(const AboutCampaign& about, const std::string& columns);
  void go_on(const AboutCampaign& about, const std::string& columns);
  void keep_committing(const std::stop_token& stop);
  void commit(std::vector<Row> rows);

  std::filesystem::path file_;
  Shard shard_;
  std::optional<Database> database_;  // of the constructor, then the thread, then finish()
  int rows_ = 0;

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<Row> waiting_;
  std::exception_ptr failure_;
  bool changes_ = false;
  std::stop_source stop_;
  ServiceThread thread_{"the table of the campaign"};
};

/// Flies the last existing run again and checks that the result is equal. Only before the first
/// add().
/// @param file  of the table
/// @throws std::invalid_argument if the result differs, or if the table has more than options.runs
///   rows
void check_continues(RunTable& table, const std::filesystem::path& file, const Scenario& scenario,
                     const CampaignPlan& plan, const CampaignOptions& options);

/// Reads the description from an open table.
AboutCampaign about_campaign(Database& database);
/// Creates `campaign` with this description, and `runs` by the SQL statement `runs`.
void create_tables(Database& database, const AboutCampaign& about, const std::string& runs);
/// Writes the rows into a new file, whose bytes depend only on them. Counts as one change of the
/// database.
void write_clean(Database& database, const std::filesystem::path& file);

/// Digest of all rows in their order; it differs if a row was modified.
std::string rows_digest(Database& database);
/// Writes the digest into `campaign`.
void write_digest(Database& database);
/// Key of the digest in `campaign`, present in a complete table.
inline constexpr std::string_view digest_key = "digest";

/// Key of the shard in `campaign`.
inline constexpr std::string_view shard_key = "shard";
/// Name of the last column, the digest of its row.
inline constexpr std::string_view row_digest_column = "digest";
/// @throws std::runtime_error naming the first run whose row was modified
void check_rows(Database& database);

/// Prefix of the key of a file that the scenario names.
inline constexpr std::string_view file_key = "file ";

/// Suffixes of the columns of a robot's energy and tracking errors, after its name.
inline constexpr std::array<std::string_view, 3> robot_endings = {".energy", ".rms_position_error",
                                                                  ".rms_heading_error"};

/// The same for a robot that is localized by vision: estimation error, consistency, and longest
/// time without a detection.
inline constexpr std::array<std::string_view, 3> localization_endings = {".rmse", ".anees",
                                                                         ".longest_without_sight"};

/// The same for the observer of a certified view, as in RobotView.
inline constexpr std::array<std::string_view, 3> view_endings = {".view_certified", ".view_active",
                                                                 ".view_uncertified"};

/// The columns of `runs` that do not depend on the draws.
std::vector<std::string> fixed_columns();

}  // namespace sightline
