/// An event of a script as a person reads it: "at 20 s: remove uav2".
#pragma once

#include <string>

#include "sightline/ocp/event.hpp"

namespace sightline {

std::string in_words(const Trigger& trigger, const Team& team);
std::string in_words(const Action& action, const Team& team);

/// Its name, when it happens, and what it changes.
std::string in_words(const TeamEvent& event, const Team& team);

}  // namespace sightline
