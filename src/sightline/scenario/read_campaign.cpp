#include "sightline/scenario/read_campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <stdexcept>

#include "sightline/scenario.hpp"
#include "sightline/scenario/layers.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/scenario/set_value.hpp"
#include "sightline/scenario/templates.hpp"

namespace sightline {
namespace {

constexpr std::array<std::string_view, 6> distribution_keys = {"uniform",   "normal",   "choice",
                                                               "fractions", "constant", "fraction"};
constexpr std::array<std::string_view, 3> distribution_kinds = {"uniform", "normal", "choice"};

std::vector<double> read_fractions(const TomlTable& at, std::size_t choices) {
  if (!at.has("fractions")) return std::vector<double>(choices, 1.0 / static_cast<double>(choices));
  std::vector<double> fractions = at.numbers("fractions", choices, {0.0, 1.0, "0 to 1"});
  if (std::abs(std::accumulate(fractions.begin(), fractions.end(), 0.0) - 1.0) > 1e-9)
    at.throw_invalid("fractions", "fractions that sum to 1");
  return fractions;
}

/// Reads the keys of a distribution; all its values must lie in the range.
Distribution read_distribution(const TomlTable& at, const Range& range) {
  Distribution d;
  const auto given = std::count_if(distribution_kinds.begin(), distribution_kinds.end(),
                                   [&](std::string_view kind) { return at.has(kind); });
  if (given != 1) at.throw_invalid("exactly one of uniform, normal and choice");
  if (at.has("uniform")) {
    d.values = at.numbers("uniform", 2, range);
    if (d.values[0] > d.values[1]) at.throw_invalid("uniform", "[low, high] with low <= high");
  } else if (at.has("normal")) {
    d.kind = Distribution::Kind::normal;
    d.values = at.numbers("normal", 2);
    if (d.values[1] < 0) at.throw_invalid("normal", "[mean, standard deviation] with a deviation >= 0");
  } else {
    d.kind = Distribution::Kind::choice;
    d.values = at.numbers("choice", TomlTable::any_length, range);
    d.fractions = read_fractions(at, d.values.size());
  }
  if (at.has("fractions") && d.kind != Distribution::Kind::choice)
    at.throw_invalid("fractions", "no such key without choice");
  if (at.has("constant") != at.has("fraction")) {
    at.throw_invalid(at.has("constant") ? "fraction" : "constant", "both constant and fraction, or neither");
  }
  if (at.has("constant")) {
    d.constant = at.number("constant", range);
    d.fraction = at.number("fraction", {0.0, 1.0, "0 to 1"});
  }
  return d;
}

/// Reads the distributions and finds the numbers that they apply to.
class PlanReader {
 public:
  PlanReader(ScenarioNumbers numbers, const Team& team) : numbers_(std::move(numbers)), team_(team) {
    for (const auto& [key, number] : numbers_) {
      if (!key.starts_with("campaign.")) keys_.push_back(key);
    }
  }

  StartDraw read_start(const TomlTable& at) {
    at.expect_only({"agent", "around", "range", "bearing", "height", "heading", "v"});
    StartDraw start{
        .agent = read_name(at, "agent", team_, Among::robots, "a robot"),
        .around = read_name(at, "around", team_, Among::bodies, "a robot, a target or an obstacle"),
        .range = distribution(at, "range", not_negative("0 to 1e9 m")),
        .bearing = distribution(at, "bearing", any_number("finite [rad]")),
        .height = distribution(at, "height", any_number("finite [m]"))};
    if (start.agent == start.around) at.throw_invalid("around", "another body than agent");
    if (at.has("heading")) start.heading = distribution(at, "heading", any_number("finite [rad]"));
    if (at.has("v")) start.velocity = distribution(at, "v", any_number("finite [m/s]"));

    const std::string own = fmt::format("agent.{}.start.", start.agent);
    expect_written(at, "agent", own + "heading");
    for (int i = 0; i < 3; ++i) {
      claim(at, "agent", fmt::format("{}p[{}]", own, i));
      expect_written(at, "around", position_key(start.around, i));
    }
    if (start.heading) claim(at, "heading", own + "heading");
    if (start.velocity) {
      for (const char* v : {"v[0]", "v[1]"}) claim(at, "v", own + v);
    }
    return start;
  }

  NumberDraw read_draw(const TomlTable& at) {
    std::vector<std::string_view> known(distribution_keys.begin(), distribution_keys.end());
    known.insert(known.end(), {"key", "also"});
    at.expect_only(known);
    NumberDraw draw{read_key(at), read_distribution(at, any_number())};
    const double value = draw.distribution.values[0];
    note_missing(at, draw.key, value);
    for (const TomlTable& inner : at.tables("also")) {
      NumberDraw::Linked linked{read_key(inner)};
      inner.read({{"times", &linked.times}, {"plus", &linked.plus}}, {"key"});
      note_missing(inner, linked.key, linked.times * value + linked.plus);
      draw.also.push_back(linked);
    }
    return draw;
  }

  /// Checks that the scenario accepts drawn keys that the file does not contain.
  void try_missing(const std::function<void(const std::vector<std::string>& set)>& try_set) const {
    if (missing_.empty()) return;
    std::vector<std::string> set;
    for (const Missing& missing : missing_) set.push_back(missing.assignment);
    try {
      try_set(set);
    } catch (const ScenarioError& error) {
      const auto found = std::find_if(missing_.begin(), missing_.end(), [&](const Missing& missing) {
        return error.file() == set_layer(missing.assignment).name;
      });
      if (found == missing_.end()) refuse_key(missing_.front().at, error.what());
      refuse_key(found->at, error.sentence());
    }
  }

 private:
  /// Reads the key of a number in the file that a campaign may draw.
  std::string read_key(const TomlTable& at) {
    std::string key = at.text("key", "the key of a number in this file, as agent.uav0.start.p[0]");
    if (key.starts_with("campaign.")) refuse_key(at, "those of [campaign] are not drawn");
    if (key == "simulation.seed" || key == "simulation.duration")
      at.throw_invalid("key", "another number, each run has the campaign's own seed and duration");
    if (!drawn_.insert(key).second) at.throw_invalid("key", fmt::format("{} to be drawn once", key));
    return key;
  }

  void note_missing(const TomlTable& at, const std::string& key, double value) {
    if (numbers_.contains(key)) return;
    try {
      missing_.push_back({at, assignment(key, value)});
    } catch (const std::invalid_argument& error) {
      refuse_key(at, error.what());
    }
  }

  [[noreturn]] void refuse_key(const TomlTable& at, std::string_view why) const {
    const std::string key = at.text("key", "");
    const std::vector<std::string_view> all(keys_.begin(), keys_.end());
    const auto near = nearest(shortened(key, shown_size), all);
    at.throw_invalid(
        "key",
        fmt::format("the key of a number that this file writes out or may{} ({})",
                    near ? fmt::format(", the nearest it writes is \"{}\"", *near) : std::string(), why));
  }

  std::string position_key(const std::string& name, int i) const {
    if (team_.is_agent(team_.find(name))) return fmt::format("agent.{}.start.p[{}]", name, i);
    const std::string target = fmt::format("target.{}.p[{}]", name, i);
    return numbers_.contains(target) ? target : fmt::format("obstacle.{}.p[{}]", name, i);
  }

  static Distribution distribution(const TomlTable& at, std::string_view key, const Range& range) {
    const TomlTable inner = at.table(key, "a distribution, as { uniform = [0.0, 1.0] }");
    inner.expect_only(distribution_keys);
    return read_distribution(inner, range);
  }

  void expect_written(const TomlTable& at, std::string_view key, const std::string& number) const {
    if (numbers_.contains(number)) return;
    at.throw_invalid(key, fmt::format("{} to be a number that this file writes out", number));
  }

  /// Marks a number of the file as drawn; rejects a second draw.
  void claim(const TomlTable& at, std::string_view key, const std::string& number) {
    expect_written(at, key, number);
    if (!drawn_.insert(number).second) at.throw_invalid(key, fmt::format("{} to be drawn once", number));
  }

  ScenarioNumbers numbers_;
  std::vector<std::string> keys_;
  const Team& team_;
  std::set<std::string> drawn_;
  struct Missing {
    TomlTable at;
    std::string assignment;  // "KEY=VALUE", of a drawn value
  };
  std::vector<Missing> missing_;
};

EvasionColumns read_columns(const TomlTable& at) {
  EvasionColumns columns;
  at.expect_only({"min_obstacle", "min_target", "max_target", "max_angle"});
  columns.min_obstacle = at.numbers("min_obstacle", TomlTable::any_length);
  const std::size_t runs = columns.min_obstacle.size();
  columns.min_target = at.numbers("min_target", runs);
  columns.max_target = at.numbers("max_target", runs);
  columns.max_angle = at.numbers("max_angle", runs);
  return columns;
}

}  // namespace

EvasionPlan read_evasion(const TomlTable& at, const Team& team) {
  EvasionPlan plan;
  read_keys(at, {"agent", "target", "obstacle", "published"}, plan);
  plan.agent = read_name(at, "agent", team, Among::robots, "a robot");
  plan.target = read_name(at, "target", team, Among::bodies, "another body");
  plan.obstacle = read_name(at, "obstacle", team, Among::bodies, "another body");
  if (at.has("published")) plan.published = read_columns(at.table("published"));
  return plan;
}

namespace {

CampaignPlan read_plan(const TomlDocument& document, ScenarioNumbers numbers, const Team& team,
                       const std::function<void(const std::vector<std::string>& set)>& try_set) {
  CampaignPlan plan;
  const TomlTable at = TomlTable(document).table("campaign");
  read_keys(at, {"start", "draw", "evasion"}, plan);
  if (at.has("start_outside")) plan.start_outside = at.boolean("start_outside");
  if (at.has("evasion")) plan.evasion = read_evasion(at.table("evasion"), team);
  PlanReader reader(std::move(numbers), team);
  for (const TomlTable& start : at.tables("start")) plan.starts.push_back(reader.read_start(start));
  for (const TomlTable& draw : at.tables("draw")) plan.draws.push_back(reader.read_draw(draw));
  reader.try_missing(try_set);
  return plan;
}

}  // namespace

void read_campaign(const TomlDocument& document, const std::string& text, const ScenarioChanges& changes,
                   ScenarioSpec& scenario) {
  if (!document.root.contains("campaign")) return;
  const std::filesystem::path file = document.file;
  // Tests drawn keys that the file lacks in the scenario without [campaign].
  const auto try_set = [&](const std::vector<std::string>& set) {
    TomlDocument flight = parse_toml(text, document.file);
    flight.root.erase("campaign");
    parse_spec(printed(flight), file, *document.registry, {.files = changes.files, .set = set});
  };
  try {
    scenario.campaign =
        read_plan(as_written(document), numbers_of(parse_toml(text, document.file)), scenario.team, try_set);
  } catch (const ScenarioError& error) {
    scenario.campaign_refusal = error;
  }
}

}  // namespace sightline
