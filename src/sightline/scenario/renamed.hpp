/// Keys and words renamed since version 0.2: an error names the present name, and
/// with_present_names() rewrites a text.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// @throws ScenarioError at the first key or word of a document that has another name now
void refuse_old_names(const TomlDocument& document);

/// A rewritten text and its changes.
struct RenamedText {
  std::string text;
  std::vector<std::string> changes;  ///< one sentence each, `file:line: agent.uav1.watches is observes now`
};

/// The text of one file with present names in place of old ones. All else, comments too, stays byte
/// for byte.
/// @throws ScenarioError as parse_layer()
RenamedText with_present_names(std::string_view text, const std::string& file);

}  // namespace sightline
