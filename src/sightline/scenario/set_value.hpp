/// Values of a scenario that are set from outside of its file.
#pragma once

#include <string_view>

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// Sets one value, "couple[0].weight=0.5": the key as refusals name it, the value as in TOML. A key that is missing is
/// added to its table, tables that are missing too; of an array, what is there can be set. What the value means is
/// checked where the scenario is read.
/// @throws ScenarioError where the assignment is none, or its place cannot be
void set_value(TomlDocument& document, std::string_view assignment);

}  // namespace sightline
