#include "sightline/campaign/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/io/version.hpp"

namespace sightline {

std::vector<std::string> fixed_columns() {
  std::vector<std::string> names = {
      "index",       "seed",       "outcome", "min_distance", "time_to_first_view", "fraction_in_view",
      "could_brake", "violations", "energy"};
  for (int i = 0; i < status_count; ++i)
    names.push_back(fmt::format("status_{}", to_string(static_cast<Status>(i))));
  return names;
}

RunTable::RunTable(const std::filesystem::path& file, const Scenario& scenario, const CampaignPlan& plan,
                   std::uint64_t seed)
    : database_(file, Database::Open::anew) {
  constexpr std::string_view types[] = {
      "INTEGER PRIMARY KEY", "INTEGER NOT NULL", "TEXT NOT NULL", "REAL", "REAL", "REAL",
      "INTEGER NOT NULL",    "INTEGER NOT NULL", "REAL NOT NULL"};
  std::vector<std::string> columns, marks;
  for (const std::string& name : fixed_columns()) {
    const bool typed = columns.size() < std::size(types);
    columns.push_back(
        fmt::format("{} {}", sql_name(name), typed ? types[columns.size()] : "INTEGER NOT NULL"));
  }
  for (const std::string& name : drawn_names(plan))
    columns.push_back(fmt::format("{} REAL NOT NULL", sql_name(name)));
  for (const Agent& agent : scenario.team.agents())
    columns.push_back(fmt::format("{} REAL NOT NULL", sql_name(agent.name + std::string(energy_ending))));
  marks.resize(columns.size(), "?");

  database_.execute("CREATE TABLE campaign(key TEXT PRIMARY KEY, value) WITHOUT ROWID");
  database_.execute(fmt::format("CREATE TABLE runs({})", fmt::join(columns, ", ")));
  Database::Statement about(database_, "INSERT INTO campaign VALUES(?, ?)");
  const auto tell = [&](std::string_view key, const auto& value) {
    about.reset();
    about.bind(0, key);
    about.bind(1, value);
    about.step();
  };
  tell("scenario", std::string_view(scenario.name));
  tell("text", std::string_view(scenario.text));
  tell("seed", static_cast<std::int64_t>(seed));
  tell("duration", plan.duration);
  tell("version", std::string_view(version));
  tell("compiler", std::string_view(compiler));
  insert_.emplace(database_, fmt::format("INSERT INTO runs VALUES({})", fmt::join(marks, ", ")));
}

void RunTable::add(const RunDraw& run, const RunResult& result) {
  if (waiting_ == 0) database_.execute("BEGIN");
  insert_->reset();
  int i = 0;
  insert_->bind(i++, static_cast<std::int64_t>(run.index));
  insert_->bind(i++, static_cast<std::int64_t>(run.seed));
  insert_->bind(i++, to_string(result.outcome));
  for (const double value : {result.min_distance, result.time_to_first_view, result.fraction_in_view})
    insert_->bind(i++, value);
  insert_->bind(i++, static_cast<std::int64_t>(result.could_brake));
  insert_->bind(i++, result.violations);
  insert_->bind(i++, result.energy);
  for (const std::int64_t count : result.statuses) insert_->bind(i++, count);
  for (const double value : run.values) insert_->bind(i++, value);
  for (const double value : result.energies) insert_->bind(i++, value);
  insert_->step();
  if (++waiting_ == rows_at_once) finish();
}

void RunTable::finish() {
  if (waiting_ == 0) return;
  insert_->reset();
  database_.execute("COMMIT");
  waiting_ = 0;
}

}  // namespace sightline
