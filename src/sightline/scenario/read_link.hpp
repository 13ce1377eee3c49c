/// [fleet] and [agent.NAME.link].
#pragma once

#include <optional>
#include <string>

#include "sightline/scenario/link.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// [fleet]; none without it.
/// @throws ScenarioError
std::optional<FleetNetwork> read_fleet(const TomlTable& root);

/// [agent.NAME.link], which each robot of a fleet has, and no other.
/// @param fleet  whether there is a [fleet]
/// @throws ScenarioError
std::optional<Link> read_link(const TomlTable& agent, const std::string& name, bool fleet);

/// One line each, for the summary of a scenario.
std::string in_words(const FleetNetwork& network);
std::string in_words(const Link& link, std::string_view name);

}  // namespace sightline
