/// Regions of a scenario: limits as text, in the scenario itself or in a file that several share.
#pragma once

#include "sightline/io/toml_table.hpp"
#include "sightline/potential/region.hpp"

namespace sightline {

/// `{ inside = ..., parameters = {...}, slope = {...}, kappa_A = ..., smooth = ... }`, or
/// `{ file = "sensors/camera.toml", ... }`: what that file says, its path relative to the scenario's, but for
/// what is said here, and named after it.
Region read_region(const TomlTable& at);

/// The limits under `key`, with the `parameters` beside it; or the region of a file, `{ file = ... }`.
Region read_inside(const TomlTable& at, std::string_view key);

/// Where the formula under `key` is at most 0: its violation is the formula's value.
Region read_formula(const TomlTable& at, std::string_view key);

}  // namespace sightline
