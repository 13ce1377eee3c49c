#include "sightline/scenario/robot_parts.hpp"

#include <fmt/format.h>

#include <map>

#include "sightline/model/ground_robots.hpp"
#include "sightline/model/point_mass.hpp"
#include "sightline/model/robots.hpp"
#include "sightline/model/text_robot.hpp"
#include "sightline/model/velocity_multirotor.hpp"
#include "sightline/scenario/region_parts.hpp"

namespace sightline {
namespace {

template <class M>
Model read_multirotor(const TomlTable& at) {
  M m;
  at.read({{"b_z", &m.b_z},
           {"b_psi", &m.b_psi},
           {"a_f", &m.a_f},
           {"b_f", &m.b_f},
           {"a_s", &m.a_s},
           {"b_s", &m.b_s}});
  return m;
}

Model read_omni_rover(const TomlTable& at) {
  OmniRover m;
  at.read({{"b_psi", &m.b_psi}, {"a_f", &m.a_f}, {"b_f", &m.b_f}, {"a_s", &m.a_s}, {"b_s", &m.b_s}});
  return m;
}

Model read_unicycle(const TomlTable& at) {
  Unicycle m;
  at.read({{"b_psi", &m.b_psi}, {"a_f", &m.a_f}, {"b_f", &m.b_f}});
  return m;
}

Model read_point_mass(const TomlTable& at) {
  PointMass m;
  at.read({{"drag", &m.drag, not_negative(">= 0 1/s")}});
  return m;
}

/// The vehicle that `preset` names; [0] is the default.
using MakeVehicle = VelocityMultirotor (*)();
constexpr std::array vehicles = {
    Named<MakeVehicle>{"px4", VelocityMultirotor::px4},
    Named<MakeVehicle>{"ar_drone", VelocityMultirotor::ar_drone},
};

Model read_velocity_multirotor(const TomlTable& at) {
  VelocityMultirotor m =
      (at.has("preset") ? find(vehicles, at.word("preset", names(vehicles))) : vehicles.front().read)();
  constexpr Range lag = {1e-3, 1e3, "0.001 to 1000 s"}, lag_or_none = {0.0, 1e3, "0 or 0.001 to 1000 s"};
  at.read({{"tau_f", &m.tau_f, lag},
           {"tau_s", &m.tau_s, lag},
           {"tau_z", &m.tau_z, lag_or_none},
           {"tau_psi", &m.tau_psi, lag_or_none},
           {"v_max", &m.v_max, positive("> 0 m/s")},
           {"climb_max", &m.climb_max, positive("> 0 m/s")},
           {"yaw_max", &m.yaw_max, positive("> 0 rad/s")}},
          {"preset"});
  if (m.tau_z != 0 && m.tau_z < lag.low) at.refuse("tau_z", lag_or_none.expected);
  if (m.tau_psi != 0 && m.tau_psi < lag.low) at.refuse("tau_psi", lag_or_none.expected);
  if (m.tau_z == 0 && m.tau_psi == 0) return LaggedMultirotor<Lags::plane>::of(m);
  if (m.tau_z == 0) return LaggedMultirotor<Lags::yaw>::of(m);
  if (m.tau_psi == 0) return LaggedMultirotor<Lags::climb>::of(m);
  return m;
}

using ReadRobot = Model (*)(const TomlTable& parameters);
constexpr std::array robots = {
    Named<ReadRobot>{Multirotor::name, read_multirotor<Multirotor>},
    Named<ReadRobot>{AngleMultirotor::name, read_multirotor<AngleMultirotor>},
    Named<ReadRobot>{OmniRover::name, read_omni_rover},
    Named<ReadRobot>{Unicycle::name, read_unicycle},
    Named<ReadRobot>{PointMass::name, read_point_mass},
    Named<ReadRobot>{VelocityMultirotor::name, read_velocity_multirotor},
};

// --- robots as text ---

constexpr std::string_view of_parameter = "a number or a formula in quotes",
                           of_heading = "the state psi, an array of the two of the direction, or none";

/// Names under `key`, each for itself.
std::vector<std::string> read_names(const TomlTable& at, std::string_view key, std::size_t most) {
  const std::string expected = fmt::format("1 to {} names", most);
  std::vector<std::string> list = at.texts(key, TomlTable::any_length, "names");
  if (list.empty() || list.size() > most) at.refuse(key, expected);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool twice = std::find(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(i), list[i]) !=
                       list.begin() + static_cast<std::ptrdiff_t>(i);
    if (!is_free_name(list[i]) || twice)
      at.refuse(key, i, "a name of its own: letters, digits and _, no function or unit");
  }
  return list;
}

/// One of the states, under `key` or at `i` there.
void check_state(const TomlTable& at, std::string_view key, std::size_t i, const std::string& name,
                 const TextRobot& robot) {
  if (std::find(robot.states.begin(), robot.states.end(), name) != robot.states.end()) return;
  const std::vector<std::string_view> known(robot.states.begin(), robot.states.end());
  at.refuse(key, i, fmt::format("a state, the nearest is \"{}\"", nearest(name, known)));
}

std::vector<std::string> read_heading(const TomlTable& at, const TextRobot& robot) {
  const TomlValue value = at.value("heading", of_heading);
  if (value.is_text()) {
    const std::vector<std::string_view> known(robot.states.begin(), robot.states.end());
    return {std::string(at.word("heading", known, "a state"))};
  }
  if (!value.is_array()) value.refuse(of_heading);
  std::vector<std::string> list = at.texts("heading", 2, "states");
  for (std::size_t i = 0; i < list.size(); ++i) check_state(at, "heading", i, list[i], robot);
  return list;
}

Model read_text(const TomlTable& at, const TomlTable& parameters) {
  at.expect_only({"states", "inputs", "f", "position", "heading", "u_min", "u_max"});
  TextRobot robot;
  robot.states = read_names(at, "states", text_states_max);
  robot.inputs = read_names(at, "inputs", text_inputs_max);
  for (std::size_t i = 0; i < robot.inputs.size(); ++i) {
    if (std::find(robot.states.begin(), robot.states.end(), robot.inputs[i]) != robot.states.end())
      at.refuse("inputs", i, "a name of its own, a state has this one");
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
    return read_text(own.table("text", "a robot as text"), parameters);
  }
  return find(robots, agent.word("robot", names(robots)))(parameters);
}

}  // namespace sightline
