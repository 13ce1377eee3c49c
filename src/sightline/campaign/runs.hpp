/// Queries of one table of runs.
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
#include "sightline/judge.hpp"

namespace sightline {

/// A table of runs and the name of its scenario.
struct CampaignTable {
  std::string name;
  std::filesystem::path file;  ///< campaign.sqlite
};

/// The runs of a table. Columns are named as in SQL, quoted by sql_name() if necessary. Every call
/// throws std::runtime_error if the table cannot be read or lacks the column.
class Runs {
 public:
  explicit Runs(const CampaignTable& table);

  std::int64_t count(const std::string& where = "1");
  std::int64_t count(Outcome outcome);
  /// The smallest value of the column that is not below the fraction `share` of the values; NaN
  /// without values.
  double quantile(std::string_view column, double share);
  /// Values of a column that are not null.
  std::vector<double> values(std::string_view column);
  /// Histogram of a column over `bins` equal intervals from low to high; the end bins include
  /// values beyond.
  std::vector<double> histogram(std::string_view column, double low, double high, int bins);
  /// Map of one robot's starts, by the range and bearing of the other body.
  SuccessMap map_of(const std::string& agent, double range_max);
  /// Reasons of the first failed runs, by the indices of the runs.
  std::vector<std::pair<std::int64_t, std::string>> reasons(int at_most);
  /// Names of the columns of the robots' energies, in the order of the team.
  std::vector<std::string> energies();
  std::vector<std::string> ending_in(std::string_view ending);
  /// Value of a key of `campaign`; null if it is missing.
  Database::Value word(std::string_view key);

  Database& database() { return *database_; }
  const std::string name;

 private:
  std::unique_ptr<Database> database_;
};

}  // namespace sightline
