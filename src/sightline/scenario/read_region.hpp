/// Reads regions of a scenario: limits as text, in the scenario itself or in a shared file.
#pragma once

#include <string>
#include <string_view>

#include "sightline/potentials.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// `{ inside = ..., parameters = {...}, slope = {...}, kappa_A = ..., smooth = ... }`, or `{ file =
/// "sensors/camera.toml", ... }`: the region of that file, under its name, with the keys given here
/// instead. The path is relative to the scenario.
Region read_region(const TomlTable& at);

/// The limits under `key`, with the `parameters` in the same table; or the region of a file, `{
/// file = ... }`.
Region read_inside(const TomlTable& at, std::string_view key);

/// The region where the formula under `key` is at most 0; its violation is the formula's value.
Region read_formula(const TomlTable& at, std::string_view key);

/// A number, or a formula in quotes, as text.
std::string formula_text(const TomlValue& value, std::string_view expected);

/// Runs `read`; reports an invalid formula at its place in the value.
template <class Read>
auto in_text(const TomlValue& value, Read&& read) {
  try {
    return read();
  } catch (const FormulaError& error) {
    value.refuse_at(error.offset(), error.sentence());
  }
}

}  // namespace sightline
