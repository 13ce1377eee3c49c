/// The parts that a scenario chooses by name: potentials, references, solvers; robots are in robot_parts. A new one is a
/// line in its table.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "sightline/scenario/robot_parts.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// The robot that looks: the first of a coupling, or the one that is constrained.
struct Observer {
  std::string name;
  std::optional<SensorMount> mount;  ///< of its [agent.NAME.sensor]
};

/// Which bodies of a team are meant.
enum class Among { robots, bodies };

/// Their names, in the order of the team.
std::vector<std::string_view> body_names(const Team& team, Among among);

/// The name under `key` of one of them; `expected` says what they are.
std::string read_name(const TomlTable& at, std::string_view key, const Team& team, Among among,
                      std::string_view expected);

/// A name under `key` that stands for no body: of an event, a stage, a coupling.
std::string read_label(const TomlTable& at, std::string_view key);

/// `potential = { NAME = {...} }` of [[couple]] or [[constrain]]; its `weight`.
Weighted read_potential(const TomlTable& at, const Observer& observer);

/// `{ NAME = {...}, weight = ... }`, an entry of a list of potentials.
Weighted read_weighted(const TomlTable& at, const Observer& observer);

/// `limit = { NAME = {...} }` of [[constrain]].
RelaxedBarrier read_limit(const TomlTable& at);

/// `reference = { NAME = ... }` of [agent.NAME].
Reference read_reference(const TomlTable& agent, const Model& model);

/// [solver].
SolverChoice read_solver(const TomlTable& solver, const Horizon& horizon);

}  // namespace sightline
