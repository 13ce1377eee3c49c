/// Keys of a scenario that change nothing in it.
#pragma once

#include <string>
#include <vector>

namespace sightline {

struct Scenario;

/// A sentence for each key that no body, or nothing else, of the scenario takes up: wind where no robot has an
/// acceleration of G among its rates, a floor where every robot drives, margins of a barrier that is off.
std::vector<std::string> keys_without_effect(const Scenario& scenario);

}  // namespace sightline
