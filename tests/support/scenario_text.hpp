/// Scenarios and parts of them that are read from a text alone.
#pragma once

#include <string>

#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_robot.hpp"
#include "tests/support/refusal.hpp"

namespace sightline::test {

/// The scenario of a file a.toml, which may have links.
inline Scenario scenario_of(const std::string& text) { return parse_scenario(text, "a.toml", with_links()); }

inline std::string scenario_refusal(const std::string& text) {
  return refusal_of<ScenarioError>([&] { scenario_of(text); });
}

/// The robot of a table.
inline Model robot_of(const std::string& text) {
  const TomlDocument document = parse_toml(text, "a");
  return read_robot(TomlTable(document));
}

}  // namespace sightline::test
