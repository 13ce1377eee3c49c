/// Expands templates, numbered names and placements of similar robots, before a scenario is read.
///
///     [template.follower]                                # any part of a robot, target or obstacle
///     R = [0.1, 0.1, 0.1, 0.1]
///
///     [agent."uav{00..31}"]                              # uav00, uav01, ... uav31
///     inherits = "follower"
///     start.p = { place = "circle", centre = [0.0, 0.0, 1.5], radius = 8.0 }
///     start.heading = { face = [0.0, 0.0] }
///
/// A table's own keys override those of its template; `start`, `parameters` and `sensor` merge key
/// by key. A template may inherit another. In lists of names, "uav{0..7}" expands to eight names.
/// Full description: docs/templates.md.
#pragma once

#include <string>

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// Greatest number of names in one range.
inline constexpr int range_max = 1024;

/// Replaces templates and ranges by the robots, targets and obstacles that they define. The result
/// keeps the lines of the file, so that an error names the right line.
/// @throws ScenarioError for an unknown or unused template, a cycle of templates, an invalid range,
/// a duplicate name
void expand(TomlDocument& document);

/// The document as TOML, sections and keys in the order of the file, without its comments.
std::string printed(const TomlDocument& document);

}  // namespace sightline
