#include "sightline/campaign/result_file.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>
#include <variant>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/campaign/confidence.hpp"
#include "sightline/campaign/paired.hpp"
#include "sightline/campaign/runs.hpp"
#include "sightline/campaign/table.hpp"
#include "sightline/judge.hpp"

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

Json as_json(const MedianBounds& bounds) {
  return {{"median", bounds.median}, {"low", bounds.low}, {"high", bounds.high}};
}

Json as_json(const Database::Value& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return *whole;
  if (const auto* real = std::get_if<double>(&value)) return *real;
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  return nullptr;
}

Json table_json(const CampaignTable& table) {
  Runs runs(table);
  const auto word = [&](std::string_view key) { return as_json(runs.word(key)); };
  const std::int64_t all = runs.count();
  Json json = {{"scenario", word("scenario")}, {"runs", all},
               {"seed", word("seed")},         {"duration", word("duration")},
               {"version", word("version")},   {"compiler", word("compiler")},
               {"shard", word(shard_key)},     {"digest", word(digest_key)}};
  for (int i = 0; i < outcome_count; ++i) {
    const auto outcome = static_cast<Outcome>(i);
    const std::int64_t these = runs.count(outcome);
    Json& one = json["outcomes"][std::string(to_string(outcome))];
    one["runs"] = these;
    if (all == 0) continue;
    const Interval bounds = wilson(these, all);
    one["share"] = static_cast<double>(these) / static_cast<double>(all);
    one["low"] = bounds.low;
    one["high"] = bounds.high;
  }
  std::vector<std::string> columns = {"time_to_first_view", "fraction_in_view", "min_distance", "energy"};
  for (const std::string_view ending : robot_endings)
    for (const std::string& column : runs.ending_in(ending)) columns.push_back(column);
  for (const std::string& column : columns) {
    std::vector<double> values = runs.values(sql_name(column));
    const std::size_t known = values.size();
    Json& one = json["medians"][column];
    if (values.empty()) continue;
    one = as_json(bootstrap_median(std::move(values)));
    one["runs"] = known;
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
  write_text(folder / machines_file, json_text(json, 2) + "\n");
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
      throw_invalid("{}: holds no list of machines, expected what a campaign wrote", file.native());
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
  return json_text(json, 2) + "\n";
}

}  // namespace sightline
