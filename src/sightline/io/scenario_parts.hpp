/// The parts that a scenario chooses by name: robots, potentials, references, solvers. A new one is a line in
/// its table in scenario_parts.cpp.
#pragma once

#include <optional>
#include <string>

#include "sightline/io/scenario.hpp"
#include "sightline/io/toml_table.hpp"

namespace sightline {

/// The robot that looks: the first of a coupling, or the one that is constrained.
struct Observer {
  std::string name;
  std::optional<SensorMount> mount;  ///< of its [agent.NAME.sensor]
};

/// `robot` and `parameters` of [agent.NAME].
Model read_robot(const TomlTable& agent);

/// `potential = { NAME = {...} }` of [[couple]] or [[constrain]]; its `weight`.
Weighted read_potential(const TomlTable& at, const Observer& observer);

/// `limit = { NAME = {...} }` of [[constrain]].
RelaxedBarrier read_limit(const TomlTable& at);

/// `reference = { NAME = ... }` of [agent.NAME].
Reference read_reference(const TomlTable& agent, const Model& model);

/// [solver].
SolverChoice read_solver(const TomlTable& solver, const Horizon& horizon);

}  // namespace sightline
