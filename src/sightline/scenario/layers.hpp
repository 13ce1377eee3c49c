/// A scenario in layers: base files, the file itself, and values that are set from outside.
///
///     based_on = "../pair.toml"                          # relative to this file, above its first section
///
///     [agent.uav0]                                       # sections merge key by key ...
///     parameters = { preset = "x500" }                   # ... a value after "=" replaces the lower one
///
///     [[couple]]                                         # lists of sections are appended
///
/// Full description: docs/templates.md.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// The document of a text, on top of its base files and below the values in `set`. Its nodes know
/// their source, so that an error names the file and line, or the --set.
/// @param set    "KEY=VALUE", see set_value()
/// @throws ScenarioError for a file that is missing or based on itself, and as parse_toml() and
/// set_value()
TomlDocument layered(std::string_view text, std::string file, std::span<const std::string> set);

/// Parses the document's sources again, without later changes of its root.
TomlDocument as_written(const TomlDocument& document);

/// Rewrites the text of a scenario in `file` for another location, `folder`: its relative file
/// names become relative to `folder`. A text without file names stays as it is.
/// @param file  location of the text
/// @throws ScenarioError as parse_toml()
std::string text_seen_from(const std::filesystem::path& folder, const std::string& text,
                           const std::filesystem::path& file);

}  // namespace sightline
