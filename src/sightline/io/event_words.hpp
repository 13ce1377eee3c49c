/// An event as a person reads it: "uav0: hold".
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace sightline {

/// Whether an event of this kind, as the log names it, is of a body: its value is the body's place in the team.
bool is_of_a_body(std::string_view kind);

/// @param name  of the body at that place
std::string event_words(std::string_view kind, double value, const std::function<std::string(int)>& name);

}  // namespace sightline
