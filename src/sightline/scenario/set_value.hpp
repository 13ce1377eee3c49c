/// Sets values of a scenario from outside its file.
#pragma once

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// "KEY=VALUE" of a number.
/// @throws std::invalid_argument for a key with more than a key in it, so that it sets nothing else
std::string assignment(std::string_view key, double value);

/// The layer of an assignment from outside: error messages name it "--set KEY=VALUE".
TomlLayer set_layer(std::string_view assignment);

/// Sets one value, "couple[0].weight=0.5": the key as in error messages, the value as in TOML. A
/// word that is not a TOML value is a text, "world.kind=rotors". Adds missing keys and tables; of
/// an array, only existing items can be set. The reader of the scenario checks the value.
/// @param layer  from set_layer()
/// @throws ScenarioError for an invalid assignment or place
void set_value(toml::table& root, const TomlLayer& layer);

}  // namespace sightline
