#include "sightline/campaign/weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "sightline/scenario/toml_table.hpp"

namespace sightline {
namespace {

/// A weight of a team.
struct WeightOfTeam {
  std::string name;  // as of InputGradient::parameters()
  double value;
  bool acts;  // on one of the robots
};

std::vector<WeightOfTeam> team_weights(const Team& team, std::span<const BodyId> robots) {
  const auto is_one = [&](BodyId body) {
    return std::find(robots.begin(), robots.end(), body) != robots.end();
  };
  std::vector<WeightOfTeam> weights;
  for (int b = 0; b < team.bodies(); ++b) {
    const BodyId body{b};
    if (!team.is_agent(body)) continue;
    const Agent& agent = team.agent(body);
    const auto add = [&](std::string_view name, std::span<const double> values) {
      for (std::size_t i = 0; i < values.size(); ++i)
        weights.push_back({fmt::format("{}.{}[{}]", team.name(body), name, i), values[i], is_one(body)});
    };
    add("Q", agent.Q), add("R", agent.R), add("Q_f", agent.Q_f), add("R_rate", agent.R_rate);
  }
  for (std::size_t i = 0; i < team.couplings().size(); ++i) {
    const Coupling& coupling = team.couplings()[i];
    weights.push_back({fmt::format("couple[{}].weight", i), coupling.term.weight,
                       std::any_of(coupling.felt_by.begin(), coupling.felt_by.end(), is_one)});
  }
  for (std::size_t i = 0; i < team.constraints().size(); ++i) {
    const Constraint& constraint = team.constraints()[i];
    weights.push_back(
        {fmt::format("constrain[{}].weight", i), constraint.term.weight, is_one(constraint.agent)});
  }
  return weights;
}

/// Whether a key of the text may be that of a weight: its last name, without an index.
bool names_weight(std::string_view key) {
  constexpr std::array<std::string_view, 5> names = {"weight", "Q", "R", "Q_f", "R_rate"};
  if (key.ends_with(']')) key = key.substr(0, key.rfind('['));
  key = key.substr(key.rfind('.') + 1);
  return std::find(names.begin(), names.end(), key) != names.end();
}

}  // namespace

std::vector<WeightInText> weights_of(const Scenario& scenario, std::span<const BodyId> robots,
                                     std::span<const std::string> without) {
  const std::vector<WeightOfTeam> before = team_weights(scenario.team, robots);
  std::vector<WeightInText> weights;
  for (const auto& [key, number] : numbers_of(parse_toml(scenario.text, scenario.file.native()))) {
    if (!names_weight(key) || number.value <= 0) continue;
    if (std::find(without.begin(), without.end(), key) != without.end()) continue;
    // A changed number shows which weights of the team follow from it.
    const std::pair<NumberInText, double> change = {number, 1.25 * number.value};
    const ScenarioSpec changed = parse_spec(with_numbers(scenario.text, {&change, 1}), scenario.file,
                                            *scenario.registry, {.files = scenario.files, .set = {}});
    const std::vector<WeightOfTeam> after = team_weights(changed.team, robots);
    WeightInText weight{key, number, {}};
    bool acts = false;
    for (std::size_t i = 0; i < before.size() && before.size() == after.size(); ++i) {
      const double slope = (after[i].value - before[i].value) / (change.second - number.value);
      if (slope == 0) continue;
      weight.slopes.emplace_back(before[i].name, slope);
      acts = acts || before[i].acts;
    }
    if (acts) weights.push_back(std::move(weight));
  }
  return weights;
}

}  // namespace sightline
