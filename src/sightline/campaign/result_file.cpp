#include "sightline/campaign/result_file.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "sightline/base/refuse.hpp"
#include "sightline/campaign/confidence.hpp"
#include "sightline/campaign/database.hpp"
#include "sightline/campaign/judge.hpp"
#include "sightline/campaign/paired.hpp"
#include "sightline/campaign/table.hpp"
#include "sightline/record/text_file.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::string_view machines_file = "machines.json";

std::string processor_name() {
  std::ifstream cpu("/proc/cpuinfo");
  for (std::string line; std::getline(cpu, line);) {
    const auto colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

std::vector<double> values_of(Database& database, const std::string& column) {
  std::vector<double> values;
  Database::Statement ask(database, fmt::format("SELECT {0} FROM runs WHERE {0} IS NOT NULL", column));
  while (ask.step()) values.push_back(ask.number(0).value_or(0.0));
  return values;
}

Json as_json(const MedianBounds& bounds) {
  return {{"median", bounds.median}, {"low", bounds.low}, {"high", bounds.high}};
}

Json table_json(const CampaignTable& table) {
  Database database(table.file, Database::Open::as_it_is);
  const auto word = [&](std::string_view key) -> Json {
    Database::Statement ask(database, "SELECT value FROM campaign WHERE key = ?");
    ask.bind(0, key);
    if (!ask.step()) return nullptr;
    const Database::Value value = ask.value(0);
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return *whole;
    if (const auto* real = std::get_if<double>(&value)) return *real;
    return ask.text(0);
  };
  Database::Statement count(database, "SELECT count(*) FROM runs");
  count.step();
  const std::int64_t runs = count.integer(0);
  Json json = {{"scenario", word("scenario")}, {"runs", runs},
               {"seed", word("seed")},         {"duration", word("duration")},
               {"version", word("version")},   {"compiler", word("compiler")},
               {"shard", word(shard_key)},     {"digest", word(digest_key)}};
  for (int i = 0; i < outcome_count; ++i) {
    const std::string outcome(to_string(static_cast<Outcome>(i)));
    Database::Statement these(database,
                              fmt::format("SELECT count(*) FROM runs WHERE outcome = '{}'", outcome));
    these.step();
    Json& one = json["outcomes"][outcome];
    one["runs"] = these.integer(0);
    if (runs == 0) continue;
    const Interval bounds = wilson(these.integer(0), runs);
    one["share"] = static_cast<double>(these.integer(0)) / static_cast<double>(runs);
    one["low"] = bounds.low;
    one["high"] = bounds.high;
  }
  std::vector<std::string> columns = {"time_to_first_view", "fraction_in_view", "min_distance", "energy"};
  for (const std::string& column : energy_columns(table)) columns.push_back(column);
  for (const std::string& column : columns) {
    std::vector<double> values = values_of(database, sql_name(column));
    Json& one = json["medians"][column];
    if (values.empty()) continue;
    one = as_json(bootstrap_median(values));
    one["runs"] = values.size();
  }
  return json;
}

Json paired_json(const CampaignTable& a, const CampaignTable& b) {
  const OutcomePairing outcomes = pair_outcomes(a, b);
  Json json = {{"with", a.name},
               {"runs", outcomes.runs},
               {"recovered_alone", outcomes.only_b},
               {"other_recovered_alone", outcomes.only_a},
               {"mcnemar_p", sign_test(outcomes.only_a, outcomes.only_b)}};
  const Pairing energy = pair_runs(a, b, "energy");
  if (energy.runs > 0)
    json["energy"] = {{"runs", energy.runs},
                      {"less", energy.less},
                      {"more", energy.more},
                      {"sign_test_p", sign_test(energy.less, energy.more)},
                      {"ratio", as_json(energy.ratio)},
                      {"difference", as_json(energy.difference)}};
  return json;
}

Json as_json(const Machine& machine) {
  return {{"name", machine.name},
          {"system", machine.system},
          {"processor", machine.processor},
          {"cores", machine.cores}};
}

}  // namespace

Machine this_machine() {
  utsname names{};
  ::uname(&names);
  return {.name = names.nodename,
          .system = fmt::format("{} {} {}", names.sysname, names.release, names.machine),
          .processor = processor_name(),
          .cores = static_cast<int>(std::thread::hardware_concurrency())};
}

void write_machines(const fs::path& folder, const std::vector<Machine>& machines) {
  Json json = Json::array();
  for (const Machine& machine : machines) json.push_back(as_json(machine));
  write_text(folder / machines_file, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::vector<Machine> machines_of(const std::vector<fs::path>& folders) {
  std::vector<Machine> all;
  for (const fs::path& folder : folders) {
    const fs::path file = folder / machines_file;
    if (!fs::exists(file)) continue;
    try {
      std::ifstream in(file);
      for (const Json& one : Json::parse(in)) {
        const Machine machine{one.at("name"), one.at("system"), one.at("processor"), one.at("cores")};
        if (std::find(all.begin(), all.end(), machine) == all.end()) all.push_back(machine);
      }
    } catch (const Json::exception&) {
      refuse("{}: holds no list of machines, expected what a campaign wrote", file.native());
    }
  }
  return all;
}

void note_machine(const fs::path& folder, const Machine& machine) {
  std::vector<Machine> all = machines_of({folder});
  if (std::find(all.begin(), all.end(), machine) != all.end()) return;
  all.push_back(machine);
  write_machines(folder, all);
}

std::string campaign_json(const std::vector<CampaignTable>& tables, const std::vector<Machine>& machines) {
  Json json = table_json(tables.front());
  for (const Machine& machine : machines) json["machines"].push_back(as_json(machine));
  for (std::size_t i = 1; i < tables.size(); ++i) {
    Json beside = table_json(tables[i]);
    beside["paired"] = paired_json(tables.front(), tables[i]);
    json["beside"].push_back(std::move(beside));
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace sightline
