#include "sightline/campaign/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <chrono>
#include <cmath>
#include <span>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/config.hpp"

namespace sightline {

std::vector<std::string> fixed_columns() {
  std::vector<std::string> names = {"index",
                                    "seed",
                                    "outcome",
                                    "reason",
                                    "min_distance",
                                    "time_to_first_view",
                                    "fraction_in_view",
                                    "could_brake",
                                    "violations",
                                    "energy",
                                    "chatter",
                                    "drift",
                                    "longest_without_plan",
                                    "barrier_conflict",
                                    "longest_out_of_view",
                                    "view_margin",
                                    "distance_margin",
                                    "landed"};
  for (int i = 0; i < status_count; ++i)
    names.push_back(fmt::format("status_{}", to_string(static_cast<Status>(i))));
  return names;
}

namespace {

/// Keys of the description, in the order in which a mismatch is reported.
constexpr std::array<std::string_view, 8> reported_of_campaign = {"scenario", "text",     "seed", "duration",
                                                                  "version",  "compiler", "plan", shard_key};
constexpr std::chrono::milliseconds pause{500};  // between two commits
constexpr std::size_t waiting_max = 4096;        // rows; with a slow disk, add() blocks

std::string columns_of(const Scenario& scenario, const CampaignPlan& plan) {
  constexpr std::string_view types[] = {"INTEGER PRIMARY KEY",
                                        "INTEGER NOT NULL",
                                        "TEXT NOT NULL",
                                        "TEXT",
                                        "REAL",
                                        "REAL",
                                        "REAL",
                                        "INTEGER NOT NULL",
                                        "INTEGER NOT NULL",
                                        "REAL NOT NULL",
                                        "REAL NOT NULL",
                                        "REAL",
                                        "REAL NOT NULL",
                                        "REAL",
                                        "REAL NOT NULL",
                                        "REAL",
                                        "REAL",
                                        "INTEGER NOT NULL"};
  std::vector<std::string> columns;
  for (const std::string& name : fixed_columns()) {
    const bool typed = columns.size() < std::size(types);
    columns.push_back(
        fmt::format("{} {}", sql_name(name), typed ? types[columns.size()] : "INTEGER NOT NULL"));
  }
  for (const std::string& name : drawn_names(plan))
    columns.push_back(fmt::format("{} REAL NOT NULL", sql_name(name)));
  const auto add_endings = [&](std::string_view robot, std::span<const std::string_view> endings) {
    for (const std::string_view ending : endings)
      columns.push_back(fmt::format("{} REAL", sql_name(fmt::format("{}{}", robot, ending))));
  };
  for (const Agent& agent : scenario.team.agents()) add_endings(agent.name, robot_endings);
  for (const LocalizedRobot& one : scenario.localization.robots)
    add_endings(scenario.team.name(one.robot), localization_endings);
  for (const CertifiedView& view : scenario.certified_views) {
    const std::string_view observer = scenario.team.name(view.observer);
    const auto same = [&](const CertifiedView& other) { return other.observer == view.observer; };
    const bool is_one =
        std::count_if(scenario.certified_views.begin(), scenario.certified_views.end(), same) == 1;
    add_endings(
        is_one ? std::string(observer) : fmt::format("{}.{}", observer, scenario.team.name(view.target)),
        view_endings);
  }
  columns.push_back(fmt::format("{} TEXT NOT NULL", sql_name(row_digest_column)));
  return fmt::format("CREATE TABLE runs({})", fmt::join(columns, ", "));
}

/// FNV-1a, 64 bits, of the types and values of fields.
class Digest {
 public:
  void add(const Database::Value& value) {
    const std::size_t kind = value.index();
    add(&kind, sizeof kind);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) add(whole, sizeof *whole);
    if (const auto* real = std::get_if<double>(&value)) add(real, sizeof *real);
    if (const auto* text = std::get_if<std::string>(&value)) add(text->data(), text->size());
  }
  std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  void add(const void* data, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i)
      hash_ = (hash_ ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3ULL;
  }

  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

int width_of(Database& database) {
  Database::Statement width(database, "SELECT count(*) FROM pragma_table_info('runs')");
  width.step();
  return static_cast<int>(width.integer(0));
}

std::vector<Database::Value> row_of(const RunDraw& run, const RunResult& result) {
  std::vector<Database::Value> row;
  const auto real = [&](double value) {
    Database::Value& field = row.emplace_back();
    if (!std::isnan(value)) field = value;
  };
  const auto whole = [&](std::int64_t value) { row.emplace_back(value); };
  whole(run.index);
  whole(static_cast<std::int64_t>(run.seed));
  row.emplace_back(std::string(to_string(result.outcome)));
  Database::Value& reason = row.emplace_back();
  if (!result.reason.empty()) reason = result.reason;
  for (const double value : {result.min_distance, result.time_to_first_view, result.fraction_in_view})
    real(value);
  whole(result.could_brake ? 1 : 0);
  whole(result.violations);
  for (const double value :
       {result.energy, result.chatter, result.drift, result.longest_without_plan, result.barrier_conflict,
        result.longest_out_of_view, result.view_margin, result.distance_margin})
    real(value);
  whole(result.landed ? 1 : 0);
  for (const std::int64_t count : result.statuses) whole(count);
  for (const double value : run.values) real(value);
  for (const RobotResult& robot : result.robots)
    for (const double value : {robot.energy, robot.rms_position_error, robot.rms_heading_error}) real(value);
  for (const RobotLocalization& one : result.localizations)
    for (const double value : {one.rmse, one.anees, one.longest_without_sight}) real(value);
  for (const RobotView& view : result.views)
    for (const double value : {view.certified, view.active, static_cast<double>(view.uncertified)})
      real(value);
  Digest digest;
  for (const Database::Value& value : row) digest.add(value);
  row.emplace_back(digest.text());
  return row;
}

}  // namespace

AboutCampaign about_campaign(Database& database) {
  AboutCampaign about;
  Database::Statement query(database, "SELECT key, value FROM campaign");
  while (query.step()) about.emplace(query.text(0), query.value(1));
  return about;
}

void create_tables(Database& database, const AboutCampaign& about, const std::string& runs) {
  database.execute("CREATE TABLE campaign(key TEXT PRIMARY KEY, value) WITHOUT ROWID; " + runs);
  Database::Statement insert(database, "INSERT INTO campaign VALUES(?, ?)");
  for (const auto& [key, value] : about) {
    insert.reset();
    insert.bind(0, std::string_view(key));
    insert.bind(1, value);
    insert.step();
  }
}

void write_clean(Database& database, const std::filesystem::path& file) {
  std::filesystem::remove(file);
  database.execute("PRAGMA schema_version = 1");  // a counter of rewrites, which must not depend on
                                                  // the history
  Database::Statement copy(database, "VACUUM INTO ?");
  copy.bind(0, std::string_view(file.native()));
  copy.step();
}

void write_digest(Database& database) {
  Database::Statement insert(database, "INSERT OR REPLACE INTO campaign VALUES(?, ?)");
  insert.bind(0, digest_key);
  insert.bind(1, std::string_view(rows_digest(database)));
  insert.step();
}

std::string rows_digest(Database& database) {
  Digest digest;
  const int width = width_of(database);
  Database::Statement rows(database, "SELECT * FROM runs ORDER BY \"index\"");
  while (rows.step())
    for (int i = 0; i < width; ++i) digest.add(rows.value(i));
  return digest.text();
}

void check_rows(Database& database) {
  const int last = width_of(database) - 1;
  Database::Statement rows(database, "SELECT * FROM runs ORDER BY \"index\"");
  while (rows.step()) {
    Digest digest;
    for (int i = 0; i < last; ++i) digest.add(rows.value(i));
    if (rows.text(last) != digest.text())
      throw std::runtime_error(fmt::format("the row of run {} is not as it was written", rows.integer(0)));
  }
}

RunTable::RunTable(const std::filesystem::path& file, const Scenario& scenario, const CampaignPlan& plan,
                   std::uint64_t seed, const Shard& shard, int runs)
    : file_(file), shard_(shard) {
  AboutCampaign about = {{"scenario", scenario.name},
                         {"text", scenario.text},
                         {"seed", static_cast<std::int64_t>(seed)},
                         {"duration", plan.duration},
                         {"version", std::string(version)},
                         {"compiler", std::string(compiler)}};
  if (!plan.text.empty() && plan.text != scenario.text) about.emplace("plan", plan.text);
  for (const auto& [name, text] : scenario.files) about.emplace(std::string(file_key) + name, text);
  if (!shard.is_whole()) about.emplace(shard_key, fmt::format("{} of {}", to_string(shard), runs));
  const std::string columns = columns_of(scenario, plan);
  if (std::filesystem::exists(file_)) go_on(about, columns);
  if (!database_) begin(about, columns);
  thread_.start([this] { keep_committing(stop_.get_token()); },
                [this] {
                  const std::scoped_lock lock(mutex_);
                  failure_ = std::current_exception();
                  changed_.notify_all();
                });
}

// The file appears only with complete tables.
void RunTable::begin(const AboutCampaign& about, const std::string& columns) {
  const std::filesystem::path unfinished = beside(file_);
  {
    Database made(unfinished, Database::Open::anew);
    made.execute("BEGIN");
    create_tables(made, about, columns);
    made.execute("COMMIT");
  }
  std::filesystem::remove(file_.native() + "-journal");  // of a file that was removed
  std::filesystem::rename(unfinished, file_);
  database_.emplace(file_, Database::Open::as_it_is);
  changes_ = true;
}

// Closes the database if the run cannot continue.
void RunTable::go_on(const AboutCampaign& about, const std::string& columns) {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(
        fmt::format("{}: {}, expected runs of this campaign, which would go on, or none: give another folder "
                    "by -o, or move "
                    "the file away",
                    file_.native(), what));
  };
  std::vector<std::string> others;
  std::int64_t last = -1;
  try {
    database_.emplace(file_, Database::Open::as_it_is);
    Database::Statement count(*database_, "SELECT count(*), coalesce(max(\"index\"), -1) FROM runs");
    count.step();
    rows_ = static_cast<int>(count.integer(0));
    last = count.integer(1);
    AboutCampaign there = about_campaign(*database_);
    there.erase(std::string(digest_key));
    const auto differs = [&](const auto& requested) {
      const auto found = there.find(requested.first);
      return found == there.end() || found->second != requested.second;
    };
    for (const std::string_view key : reported_of_campaign)
      if (const auto requested = about.find(std::string(key));
          requested != about.end() && differs(*requested))
        others.emplace_back(key);
    for (const auto& requested : about)
      if (requested.first.starts_with(file_key) && differs(requested)) others.push_back(requested.first);
    if (there.size() != about.size() && others.empty()) others.emplace_back("plan or shard");
    Database::Statement made(*database_, "SELECT sql FROM sqlite_master WHERE name = 'runs'");
    if (!(made.step() && made.text(0) == columns)) others.emplace_back("columns");
  } catch (const std::runtime_error& error) {
    refuse(fmt::format("holds no campaign ({})", sentence_of(error)));
  }
  if (rows_ == 0) return database_.reset();
  if (!others.empty())
    refuse(fmt::format("holds {} runs of another campaign: another {}", rows_, fmt::join(others, ", ")));
  if (last != shard_.run(rows_ - 1))
    refuse(fmt::format("holds {} runs up to number {}, not one after another", rows_, last));
  try {
    check_rows(*database_);
  } catch (const std::runtime_error& error) {
    refuse(error.what());
  }
}

RunTable::~RunTable() {
  try {
    stop_.request_stop();
    thread_.join();
    if (!waiting_.empty() && !failure_) commit(std::move(waiting_));
  } catch (...) {  // finish() reports errors; it was not called
  }
}

int RunTable::rows(Outcome outcome) {
  Database::Statement count(*database_, "SELECT count(*) FROM runs WHERE outcome = ?");
  count.bind(0, to_string(outcome));
  count.step();
  return static_cast<int>(count.integer(0));
}

bool RunTable::holds(const RunDraw& run, const RunResult& result) {
  Database::Statement query(*database_, "SELECT * FROM runs WHERE \"index\" = ?");
  query.bind(0, std::int64_t{run.index});
  if (!query.step()) return false;
  const Row row = row_of(run, result);
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (query.value(static_cast<int>(i)) != row[i]) return false;
  }
  return true;
}

void RunTable::add(const RunDraw& run, const RunResult& result) {
  Row row = row_of(run, result);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return waiting_.size() < waiting_max || failure_; });
  if (failure_) std::rethrow_exception(failure_);
  waiting_.push_back(std::move(row));
  changed_.notify_all();
}

void RunTable::keep_committing(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !waiting_.empty(); })) {
    std::vector<Row> rows = std::exchange(waiting_, {});
    changed_.notify_all();
    lock.unlock();
    try {
      commit(std::move(rows));
    } catch (...) {
      lock.lock();
      failure_ = std::current_exception();
      return changed_.notify_all();
    }
    lock.lock();
    if (stop.stop_requested()) return;
    changed_.wait_for(lock, stop, pause, [] { return false; });
  }
}

void RunTable::commit(std::vector<Row> rows) {
  changes_ = true;
  std::string marks = "?";
  for (std::size_t i = 1; i < rows.front().size(); ++i) marks += ", ?";
  database_->execute(fmt::format("BEGIN; DELETE FROM campaign WHERE key = '{}'", digest_key));
  Database::Statement insert(*database_, fmt::format("INSERT INTO runs VALUES({})", marks));
  for (const Row& row : rows) {
    insert.reset();
    for (std::size_t i = 0; i < row.size(); ++i) insert.bind(static_cast<int>(i), row[i]);
    insert.step();
  }
  insert.reset();
  database_->execute("COMMIT");
}

void RunTable::finish() {
  stop_.request_stop();
  thread_.join();
  if (failure_) std::rethrow_exception(failure_);
  if (!waiting_.empty()) commit(std::exchange(waiting_, {}));
  if (!std::exchange(changes_, false)) return;
  write_digest(*database_);
  // The bytes of the file depend on the history of its rows; those of a new file do not.
  const std::filesystem::path whole = beside(file_);
  write_clean(*database_, whole);
  database_.reset();
  std::filesystem::rename(whole, file_);
}

void check_continues(RunTable& table, const std::filesystem::path& file, const Scenario& scenario,
                     const CampaignPlan& plan, const CampaignOptions& options) {
  if (table.rows() == 0) return;
  if (table.rows() > options.shard.size(options.runs)) {
    throw_invalid(
        "{}: holds {} runs of this campaign, expected at most {}: ask for as many, or give another folder by "
        "-o",
        file.native(), table.rows(), options.runs);
  }
  const Variants variants(scenario, plan);
  const RunDraw last = draw_run(plan, options.seed, options.shard.run(table.rows() - 1));
  if (!table.holds(last, RunWorker(variants, plan).fly(last))) {
    throw_invalid(
        "{}: holds {} runs, of which number {} flies otherwise now: another program, machine or file that "
        "the scenario "
        "names; give another folder by -o, or move the file away",
        file.native(), table.rows(), last.index);
  }
}

}  // namespace sightline
