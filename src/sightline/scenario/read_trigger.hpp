/// When an event of a scenario happens: `at`, `after`, `when`, `lost`, `seen` or `signal` of [[event]].
#pragma once

#include "sightline/ocp/event.hpp"
#include "sightline/scenario/read_coupling.hpp"

namespace sightline {

/// A coupling or constraint that events may speak of, by its name.
struct NamedTerm {
  std::string name;
  BodyId observer;  ///< the first of a coupling, or the robot that is constrained
  bool is_pair = true;
};

/// What the events of a scenario may speak of.
struct EventScope {
  const Team& team;  ///< every body there will ever be
  const Observers& observers;
  const Simulation& simulation;
  std::vector<Coupling> couplings{};  ///< all there may ever be, of events too
  std::vector<NamedTerm> terms{};     ///< likewise
};

/// The body of that name in a text.
BodyId read_body(const TomlValue& value, const Team& team);

/// The trigger of an event, which has exactly one.
/// @param others  keys that may stand beside it
Trigger read_trigger(const TomlTable& event, const EventScope& scope,
                     std::initializer_list<std::string_view> others);

}  // namespace sightline
