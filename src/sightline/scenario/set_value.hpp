/// Values of a scenario that are set from outside of its file.
#pragma once

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// "KEY=VALUE" of a number.
/// @throws std::invalid_argument for a key that holds more than a key, so that nothing else is set
std::string assignment(std::string_view key, double value);

/// The layer of an assignment from outside: "--set KEY=VALUE" names it in refusals.
TomlLayer set_layer(std::string_view assignment);

/// Sets one value, "couple[0].weight=0.5": the key as refusals name it, the value as in TOML; a word that is no value there is a
/// text, "world.kind=rotors". A key that is missing is added to its table, tables that are missing too; of an array, what is
/// there can be set. What the value means is checked where the scenario is read.
/// @param layer  of set_layer()
/// @throws ScenarioError where the assignment is none, or its place cannot be
void set_value(toml::table& root, const TomlLayer& layer);

}  // namespace sightline
