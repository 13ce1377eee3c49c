#include "sightline/scenario/read_robot.hpp"

#include <fmt/format.h>

#include <map>

#include "sightline/model.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/scenario/read_region.hpp"

namespace sightline {
namespace {

constexpr std::string_view of_parameter = "a number or a formula in quotes",
                           of_heading = "the state psi, an array of the two of the direction, or none";

/// Names under `key`, each different.
std::vector<std::string> read_names(const TomlTable& at, std::string_view key, std::size_t most) {
  const std::string expected = fmt::format("1 to {} names", most);
  std::vector<std::string> list = at.texts(key, TomlTable::any_length, "names");
  if (list.empty() || list.size() > most) at.throw_invalid(key, expected);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool twice = std::find(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(i), list[i]) !=
                       list.begin() + static_cast<std::ptrdiff_t>(i);
    if (!is_free_name(list[i]) || twice)
      at.throw_invalid(key, i, "a name of its own: letters, digits and _, no function or unit");
  }
  return list;
}

/// Rejects a name that is not a state, under `key` or at its item `i`.
void check_state(const TomlTable& at, std::string_view key, std::size_t i, const std::string& name,
                 const TextRobot& robot) {
  if (std::find(robot.states.begin(), robot.states.end(), name) != robot.states.end()) return;
  const std::vector<std::string_view> known(robot.states.begin(), robot.states.end());
  at.throw_invalid(key, i, "a state" + hint(name, known));
}

std::vector<std::string> read_heading(const TomlTable& at, const TextRobot& robot) {
  const TomlValue value = at.value("heading", of_heading);
  if (value.is_text()) {
    const std::vector<std::string_view> known(robot.states.begin(), robot.states.end());
    return {std::string(at.word("heading", known, "a state"))};
  }
  if (!value.is_array()) value.throw_invalid(of_heading);
  std::vector<std::string> list = at.texts("heading", 2, "states");
  for (std::size_t i = 0; i < list.size(); ++i) check_state(at, "heading", i, list[i], robot);
  return list;
}

Model read_text_robot(const TomlTable& at, const TomlTable& parameters) {
  at.expect_only({"states", "inputs", "f", "position", "heading", "u_min", "u_max"});
  TextRobot robot;
  robot.states = read_names(at, "states", text_states_max);
  robot.inputs = read_names(at, "inputs", text_inputs_max);
  for (std::size_t i = 0; i < robot.inputs.size(); ++i) {
    if (std::find(robot.states.begin(), robot.states.end(), robot.inputs[i]) != robot.states.end())
      at.throw_invalid("inputs", i, "a name of its own, a state has this one");
  }
  const std::vector<std::string> position = at.texts("position", 3, "states");
  for (std::size_t i = 0; i < 3; ++i) check_state(at, "position", i, robot.position[i] = position[i], robot);
  if (at.has("heading")) robot.heading = read_heading(at, robot);
  if (at.has("u_min")) robot.u_min = at.numbers("u_min", robot.inputs.size());
  if (at.has("u_max")) robot.u_max = at.numbers("u_max", robot.inputs.size());

  std::map<std::string, TomlValue> definitions;
  for (const std::string& name : parameters.keys()) {
    const TomlValue value = parameters.value(name, of_parameter);
    robot.parameters.push_back({name, formula_text(value, of_parameter)});
    definitions.emplace(name, value);
  }
  const Vocabulary names = [&] {
    try {
      return robot.vocabulary();
    } catch (const FormulaError& error) {
      definitions.at(error.definition()).refuse_at(error.offset(), error.sentence());
    }
  }();
  const TomlTable f = at.table("f", "a table with the rate of each state");
  f.expect_only(std::vector<std::string_view>(robot.states.begin(), robot.states.end()));
  for (const std::string& state : robot.states) {
    const TomlValue rate = f.value(state, "the rate of that state, a number or a formula in quotes");
    robot.f.push_back(formula_text(rate, of_parameter));
    if (rate.is_text()) in_text(rate, [&] { return parse_formula(robot.f.back(), names); });
  }
  return at.checked([&] { return robot.model(); });
}

}  // namespace

Model read_robot(const TomlTable& agent) {
  const TomlTable parameters = agent.table_or_empty("parameters");
  if (agent.has("robot") && agent.value("robot", "a robot").is_table()) {
    const TomlTable own = agent.table("robot");
    own.expect_only({"text"});
    return read_text_robot(own.table("text", "a robot as text"), parameters);
  }
  const PartList<Model>& robots = agent.registry().robots;
  return read_named(robots, agent.word("robot", robots.names()), parameters);
}

}  // namespace sightline
