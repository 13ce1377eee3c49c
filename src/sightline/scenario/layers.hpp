/// A scenario in layers: files that it is based on, the file itself, values that are set from outside.
///
///     based_on = "../pair.toml"                          # relative to this file, above its first section
///
///     [agent.uav0]                                       # a section is filled key by key ...
///     parameters = { preset = "x500" }                   # ... what stands behind a "=" takes the place of what was there
///
///     [[couple]]                                         # and a list of sections goes on
///
/// docs/templates.md has the whole.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// The document of a text, on top of the files that it is based on and below the values that are set. Its nodes know where
/// they stand, so that a refusal names the file and line, or the --set.
/// @param set    "KEY=VALUE", see set_value()
/// @throws ScenarioError for a file that is missing or based on itself, and as parse_toml() and set_value()
TomlDocument layered(std::string_view text, std::string file, std::span<const std::string> set);

/// The document as it was made, whatever became of its root.
TomlDocument as_written(const TomlDocument& document);

/// The text of a scenario of one folder, to be written into another: what it says of files is seen from there. One that
/// names none stays as it is.
/// @param file  that the text is of
/// @throws ScenarioError as parse_toml()
std::string text_seen_from(const std::filesystem::path& folder, const std::string& text,
                           const std::filesystem::path& file);

}  // namespace sightline
