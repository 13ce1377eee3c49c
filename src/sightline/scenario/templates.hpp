/// Robots that are alike, written once: templates, numbered names and places in a row, before a scenario's meaning.
///
///     [template.follower]                                # any part of a robot, target or obstacle
///     R = [0.1, 0.1, 0.1, 0.1]
///
///     [agent."uav{00..31}"]                              # uav00, uav01, ... uav31
///     inherits = "follower"
///     start = { p = { place = "circle", centre = [0.0, 0.0, 1.5], radius = 8.0 }, heading = { face = [0.0, 0.0] } }
///
/// A table's own keys win over those of its template; `start`, `parameters` and `sensor` are filled key by key. A template
/// may be like another. In lists of names "uav{0..7}" stands for eight. docs/templates.md has the whole.
#pragma once

#include <string>

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// Most names that one range stands for.
inline constexpr int range_max = 1024;

/// Puts robots, targets and obstacles in place of what stands for them, and takes the templates away. What comes of it
/// keeps the lines of the file, so that a refusal names the line that is wrong.
/// @throws ScenarioError for an unknown or unused template, a cycle of them, a range that is none, two of one name
void expand(TomlDocument& document);

/// The document as TOML, sections and keys in the order of the file, without its comments.
std::string printed(const TomlDocument& document);

}  // namespace sightline
