/// An event as a person reads it: "uav0: hold".
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace sightline {

/// Whether an event of this kind, as the log names it, is of a body: its value is the body's place in the team.
bool is_of_a_body(std::string_view kind);

/// Whether it is of the scenario's script: its value is the place of an [[event]].
bool is_of_the_script(std::string_view kind);

/// Names of what stands at a place.
struct EventNames {
  std::function<std::string(int)> of_body, of_event;
};
std::string event_words(std::string_view kind, double value, const EventNames& names);

}  // namespace sightline
