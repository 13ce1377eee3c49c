/// Events of a scenario, [[event]]: what is to change in flight, and when. docs/events.md.
#pragma once

#include <vector>

#include "sightline/ocp/event.hpp"
#include "sightline/scenario/read_coupling.hpp"

namespace sightline {

/// `simulation.signal`: the messages that events may wait for, in the order of their times; those that the
/// simulation does not send come last, at infinity.
std::vector<TimedSignal> read_signals(const TomlTable& simulation);

/// All of [[event]], for the team and its presence at the start; what can be known to be wrong without a flight is
/// refused.
Script read_events(const TomlTable& root, const Scenario& scenario, const Observers& observers);

}  // namespace sightline
