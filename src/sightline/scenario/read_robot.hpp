/// Reads robots of a scenario, by name or as text.
#pragma once

#include "sightline/model.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// `robot` and `parameters` of [agent.NAME]. A robot is a name, or
/// `{ text = { states = [...], inputs = [...], f = { STATE = formula }, position = [...], heading = ... } }`.
Model read_robot(const TomlTable& agent);

}  // namespace sightline
