/// Descriptions of events for people: "uav0: hold".
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace sightline {

/// True if an event of this kind, as named in the log, concerns a body; its value is the body's
/// index in the team.
bool is_of_a_body(std::string_view kind);

/// True if an event of this kind comes from the scenario's script; its value is the index of an
/// [[event]].
bool is_of_the_script(std::string_view kind);

/// Names of the body and of the [[event]] at an index.
struct EventNames {
  std::function<std::string(int)> of_body, of_event;
};
std::string event_words(std::string_view kind, double value, const EventNames& names);

}  // namespace sightline
