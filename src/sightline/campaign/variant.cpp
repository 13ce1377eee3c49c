#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "sightline/analysis.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/layers.hpp"
#include "sightline/scenario/set_value.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {
namespace {

/// Whether the number belongs to the problem of a solver, not to the flight only.
bool shapes_the_team(std::string_view key) {
  for (const std::string_view section : {"simulation.", "target.", "obstacle.", "safety", "log."}) {
    if (key.starts_with(section)) return false;
  }
  const auto is_of = [&](std::string_view table) { return key.find(table) != std::string_view::npos; };
  return !(key.starts_with("agent.") && (is_of(".start.") || is_of(".vehicle.")));
}

}  // namespace

Variants::Variants(const Scenario& base, const CampaignPlan& plan)
    : plan_(plan),
      file_(base.file),
      text_(base.text),
      name_(base.name),
      registry_(base.registry),
      solver_(base.solver) {
  const TomlDocument document = parse_toml(text_, file_.native());
  const ScenarioNumbers numbers = numbers_of(document);
  text_of_flight_ = with_spaces_for("campaign", document);
  const auto find = [&](const std::string& key) {
    const auto found = numbers.find(key);
    if (found != numbers.end()) return found->second;
    throw ScenarioError(file_.native(), 1,
                        fmt::format("{} is missing, expected the number that the campaign draws", key));
  };
  const auto written = [&](const std::string& key) {
    const auto found = numbers.find(key);
    return found != numbers.end() ? std::optional(found->second) : std::nullopt;
  };
  const auto position = [&](const std::string& body, int i) {
    for (const char* form : {"agent.{}.start.p[{}]", "target.{}.p[{}]"}) {
      const auto found = numbers.find(fmt::format(fmt::runtime(form), body, i));
      if (found != numbers.end()) return found->second;
    }
    return find(fmt::format("obstacle.{}.p[{}]", body, i));
  };
  for (const StartDraw& draw : plan_.starts) {
    Start& start = starts_.emplace_back();
    const std::string own = fmt::format("agent.{}.start.", draw.agent);
    for (int i = 0; i < 3; ++i) {
      start.p[i] = find(fmt::format("{}p[{}]", own, i));
      start.around[i] = position(draw.around, i);
    }
    start.heading = find(own + "heading");
    if (!draw.velocity) continue;
    for (int i = 0; i < 2; ++i) start.v[i] = find(fmt::format("{}v[{}]", own, i));
  }
  const std::size_t before = drawn_names(plan_).size() - plan_.draws.size();
  for (std::size_t i = 0; i < plan_.draws.size(); ++i) {
    const NumberDraw& draw = plan_.draws[i];
    bool of_team = shapes_the_team(draw.key);
    draws_.push_back({written(draw.key), draw.key, before + i, 1.0, 0.0});
    for (const NumberDraw::Linked& linked : draw.also) {
      of_team = of_team || shapes_the_team(linked.key);
      draws_.push_back({written(linked.key), linked.key, before + i, linked.times, linked.plus});
    }
    if (of_team) of_team_.push_back(before + i);
  }
  for (const auto& [key, place] :
       {std::pair{"simulation.duration", &duration_}, {"simulation.seed", &seed_}}) {
    if (const auto found = numbers.find(key); found != numbers.end()) *place = found->second;
  }
  lift_deadline(solver_);
  try_additions();
}

void Variants::try_additions() const {
  const auto is_added = [](const Drawn& drawn) { return !drawn.number; };
  if (std::none_of(draws_.begin(), draws_.end(), is_added)) return;
  const RunDraw run = draw_run(plan_, 0, 0);
  try {
    (void)of(run);
  } catch (const ScenarioError& error) {
    for (const Drawn& drawn : draws_) {
      if (!is_added(drawn) || error.file() != set_layer(assignment(drawn.key, drawn.of(run))).name) continue;
      throw ScenarioError(
          file_.native(), 1,
          fmt::format("{} is missing, expected the number that the campaign draws, or a place "
                      "for it ({})",
                      drawn.key, error.sentence()));
    }
    throw;
  }
}

void Variants::place_start(const StartDraw& draw, const Start& at, const double*& value,
                           Changes& changes) const {
  const auto now = [&](const NumberInText& number) {
    const auto changed = std::find_if(changes.begin(), changes.end(),
                                      [&](const auto& c) { return c.first.offset == number.offset; });
    return changed != changes.end() ? changed->second : number.value;
  };
  const double range = *value++, bearing = *value++, height = *value++;
  const double heading = draw.heading ? *value++ : now(at.heading);
  const SinCos<double> ahead = sincos(heading), off = sincos(bearing);
  Vec2<double> towards = rotate<double>({ahead.cos, ahead.sin}, {off.cos, off.sin});
  // Exact for straight behind, where sin(pi) is not 0 in floating point.
  if (bearing == std::numbers::pi || bearing == -std::numbers::pi) towards = {-ahead.cos, -ahead.sin};
  changes.emplace_back(at.p[0], now(at.around[0]) - range * towards.x);
  changes.emplace_back(at.p[1], now(at.around[1]) - range * towards.y);
  changes.emplace_back(at.p[2], now(at.around[2]) + height);
  if (draw.heading) changes.emplace_back(at.heading, heading);
  if (!draw.velocity) return;
  changes.emplace_back(at.v[0], *value++);
  changes.emplace_back(at.v[1], *value++);
}

Scenario Variants::of(const RunDraw& run) const { return drawn(text_, run); }

Scenario Variants::flight(const RunDraw& run) const { return drawn(text_of_flight_, run); }

Scenario Variants::drawn(std::string_view text, const RunDraw& run) const {
  Changes changes;
  // Draws by key come first: a start may be around a body whose position is drawn.
  std::vector<std::string> added;
  for (const Drawn& one : draws_) {
    if (one.number) {
      changes.emplace_back(*one.number, one.of(run));
    } else {
      added.push_back(assignment(one.key, one.of(run)));
    }
  }
  const double* value = run.values.data();
  for (std::size_t i = 0; i < starts_.size(); ++i) place_start(plan_.starts[i], starts_[i], value, changes);
  if (duration_) changes.emplace_back(*duration_, plan_.duration);
  if (seed_) changes.emplace_back(*seed_, static_cast<double>(run.seed));  // below 2^53
  return flown(with_numbers(text, changes), file_, std::move(added), run);
}

Scenario Variants::of(const RunDraw& run, const std::filesystem::path& folder) const {
  std::vector<std::string> set;
  if (!duration_) set.push_back(fmt::format("simulation.duration={}", plan_.duration));
  if (!seed_) set.push_back(fmt::format("simulation.seed={}", run.seed));
  return flown(text_seen_from(folder, of(run).text, file_), folder / (name_ + ".toml"), std::move(set), run);
}

Scenario Variants::flown(std::string text, const std::filesystem::path& file, std::vector<std::string> set,
                         const RunDraw& run) const {
  Scenario scenario = parse_scenario(std::move(text), file, registry_ ? *registry_ : built_in_registry(),
                                     {.files = {}, .set = std::move(set)});
  scenario.name = name_;
  scenario.solver = solver_;
  scenario.simulation.duration = plan_.duration;
  scenario.simulation.seed = run.seed;
  scenario.simulation.compare.clear();
  if (scenario.safety && plan_.start_outside) scenario.safety->start_outside = true;
  return scenario;
}

std::vector<double> Variants::team_values(const RunDraw& run) const {
  std::vector<double> values;
  for (const std::size_t i : of_team_) values.push_back(run.values[i]);
  return values;
}

}  // namespace sightline
