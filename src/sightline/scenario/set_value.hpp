/// Values of a scenario that are set from outside of its file.
#pragma once

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// Sets one value, "couple[0].weight=0.5": the key as refusals name it, the value as in TOML; a word that is no value there is a
/// text, "world.kind=rotors". A key that is missing is added to its table, tables that are missing too; of an array, what is
/// there can be set. What the value means is checked where the scenario is read.
/// @param layer  its text is the assignment, its name stands in the refusals
/// @throws ScenarioError where the assignment is none, or its place cannot be
void set_value(toml::table& root, const TomlLayer& layer);

}  // namespace sightline
