#include "sightline/campaign/runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/campaign/table.hpp"

namespace sightline {

Runs::Runs(const CampaignTable& table)
    : name(table.name), database_(std::make_unique<Database>(table.file, Database::Open::as_it_is)) {}

std::int64_t Runs::count(const std::string& where) {
  Database::Statement query(*database_, fmt::format("SELECT count(*) FROM runs WHERE {}", where));
  query.step();
  return query.integer(0);
}

std::int64_t Runs::count(Outcome outcome) { return count(fmt::format("outcome = '{}'", to_string(outcome))); }

double Runs::quantile(std::string_view column, double share) {
  const std::int64_t known = count(fmt::format("{} IS NOT NULL", column));
  if (known == 0) return std::numeric_limits<double>::quiet_NaN();
  const auto rank =
      std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(share * static_cast<double>(known))) - 1);
  Database::Statement query(
      *database_, fmt::format("SELECT {0} FROM runs WHERE {0} IS NOT NULL ORDER BY {0} LIMIT 1 OFFSET {1}",
                              column, rank));
  query.step();
  return query.number(0).value_or(0.0);
}

std::vector<double> Runs::values(std::string_view column) {
  std::vector<double> all;
  Database::Statement query(*database_, fmt::format("SELECT {0} FROM runs WHERE {0} IS NOT NULL", column));
  while (query.step()) all.push_back(query.number(0).value_or(0.0));
  return all;
}

std::vector<double> Runs::histogram(std::string_view column, double low, double high, int bins) {
  std::vector<double> counts(static_cast<std::size_t>(bins));
  Database::Statement query(
      *database_, fmt::format("SELECT max(0, min({0}, CAST(({1} - {2}) * {3} AS INTEGER))) AS bin, count(*) "
                              "FROM runs WHERE {1} IS NOT NULL GROUP BY bin",
                              bins - 1, column, low, bins / (high - low)));
  while (query.step())
    counts[static_cast<std::size_t>(query.integer(0))] = static_cast<double>(query.integer(1));
  return counts;
}

SuccessMap Runs::map_of(const std::string& agent, double range_max) {
  SuccessMap map{.range_max = range_max};
  Database::Statement query(
      *database_, fmt::format("SELECT {}, {}, outcome = 'recovered' FROM runs", sql_name(agent + ".range"),
                              sql_name(agent + ".bearing")));
  while (query.step())
    map.add(query.number(0).value_or(0), query.number(1).value_or(0), {1, query.integer(2)});
  return map;
}

std::vector<std::pair<std::int64_t, std::string>> Runs::reasons(int at_most) {
  std::vector<std::pair<std::int64_t, std::string>> reported;
  Database::Statement query(*database_,
                            fmt::format("SELECT \"index\", reason FROM runs WHERE reason IS NOT NULL "
                                        "ORDER BY \"index\" LIMIT {}",
                                        at_most));
  while (query.step()) reported.emplace_back(query.integer(0), query.text(1));
  return reported;
}

std::vector<std::string> Runs::energies() { return ending_in(robot_endings[0]); }

std::vector<std::string> Runs::ending_in(std::string_view ending) {
  std::vector<std::string> names;
  Database::Statement query(*database_,
                            fmt::format("SELECT name FROM pragma_table_info('runs') WHERE name LIKE '_%{}' "
                                        "ORDER BY cid",
                                        ending));
  while (query.step()) names.push_back(query.text(0));
  return names;
}

Database::Value Runs::word(std::string_view key) {
  Database::Statement query(*database_, "SELECT value FROM campaign WHERE key = ?");
  query.bind(0, key);
  return query.step() ? query.value(0) : Database::Value{};
}

}  // namespace sightline
