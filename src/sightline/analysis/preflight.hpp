/// Checks of a scenario before its flight: reasons to refuse the flight, remarks and warnings.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario/scenario.hpp"

namespace sightline {

struct Preflight {
  std::vector<std::string> refusals;  ///< reasons why it cannot be flown, with the file, a sentence each
  std::vector<std::string> remarks;   ///< rounded corners of regions, a sentence each
  std::vector<std::string> warnings;  ///< a sentence each
};

/// Runs all checks. Set-up: allocates, takes some tenths of a second.
Preflight preflight(const Scenario& scenario);

}  // namespace sightline
