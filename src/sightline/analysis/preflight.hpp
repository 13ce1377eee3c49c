/// What is known of a scenario before it flies: what cannot be flown, and what to know before a flight.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario/scenario.hpp"

namespace sightline {

struct Preflight {
  std::vector<std::string> refusals;  ///< with the file, a sentence each
  std::vector<std::string> remarks;   ///< corners that are rounded off, a sentence each
  std::vector<std::string> warnings;  ///< a sentence each
};

/// Set-up: allocates, takes some tenths of a second.
Preflight preflight(const Scenario& scenario);

}  // namespace sightline
