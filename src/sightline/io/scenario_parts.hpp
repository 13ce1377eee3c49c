/// The parts that a scenario chooses by name: robots, potentials, references, solvers. A new one is a line in
/// its table in scenario_parts.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "sightline/io/scenario.hpp"
#include "sightline/io/toml_table.hpp"

namespace sightline {

/// A name in the file and what reads the part of that name.
template <class Read>
struct Named {
  std::string_view name;
  Read read;
};

template <class Read, std::size_t n>
std::array<std::string_view, n> names(const std::array<Named<Read>, n>& list) {
  std::array<std::string_view, n> all;
  std::transform(list.begin(), list.end(), all.begin(), [](const auto& entry) { return entry.name; });
  return all;
}

template <class Read, std::size_t n>
Read find(const std::array<Named<Read>, n>& list, std::string_view name) {
  return std::find_if(list.begin(), list.end(), [&](const auto& entry) { return entry.name == name; })->read;
}

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

/// `robot` and `parameters` of [agent.NAME].
Model read_robot(const TomlTable& agent);

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
