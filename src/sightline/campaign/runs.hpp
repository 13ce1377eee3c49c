/// Questions to one table of runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/campaign/database.hpp"
#include "sightline/campaign/success_map.hpp"
#include "sightline/judge/run_evaluator.hpp"

namespace sightline {

/// A table of runs and how its scenario is called.
struct CampaignTable {
  std::string name;
  std::filesystem::path file;  ///< campaign.sqlite
};

/// The runs of a table. Columns are named as in SQL, quoted by sql_name() where they need to be.
/// Every call throws std::runtime_error where the table cannot be read, or has no such column.
class Runs {
 public:
  explicit Runs(const CampaignTable& table);

  std::int64_t count(const std::string& where = "1");
  std::int64_t count(Outcome outcome);
  /// The least of the column's values that this share of them does not exceed; not a number of none.
  double quantile(std::string_view column, double share);
  /// Its values, where there are some.
  std::vector<double> values(std::string_view column);
  /// Runs in each of `bins` stretches of the column's values between low and high; the ends take what is beyond.
  std::vector<double> histogram(std::string_view column, double low, double high, int bins);
  /// The starts of one robot, by where it saw the other body.
  SuccessMap map_of(const std::string& agent, double range_max);
  /// What went wrong in the first of the runs that failed, by their indices.
  std::vector<std::pair<std::int64_t, std::string>> reasons(int at_most);
  /// The columns of robots' energies, in the order of the team.
  std::vector<std::string> energies();
  std::vector<std::string> ending_in(std::string_view ending);
  /// A word of `campaign`; null where it says nothing of it.
  Database::Value word(std::string_view key);

  Database& database() { return *database_; }
  const std::string name;

 private:
  std::unique_ptr<Database> database_;
};

}  // namespace sightline
