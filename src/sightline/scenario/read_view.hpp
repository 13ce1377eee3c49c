/// Reads [[certify_view]], and computes the certificates.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// Reads the certified views of a scenario whose team, events and compensations are read, and adds
/// their sets to the couplings as soft limits, and to the events that turn their observers.
/// @throws ScenarioError for a view that cannot be certified, with the largest speed that can
std::vector<CertifiedView> read_certified_views(const TomlTable& root, ScenarioSpec& scenario);

/// Lines for the user: the largest certified speed, what limits it, and the set.
std::string describe(const CertifiedView& view, const Team& team);

/// What endangers a certificate of the scenario, a sentence each.
std::vector<std::string> warnings_of_views(const ScenarioSpec& scenario);

}  // namespace sightline
