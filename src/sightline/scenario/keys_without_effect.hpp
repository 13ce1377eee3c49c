/// Keys of a scenario that have no effect.
#pragma once

#include <string>
#include <vector>

namespace sightline {

struct Scenario;

/// A sentence for each key that no robot and nothing else of the scenario uses. Examples: wind if
/// no robot has an acceleration of G among its rates, a floor if every robot drives, margins of a
/// barrier that is off.
std::vector<std::string> keys_without_effect(const Scenario& scenario);

}  // namespace sightline
