/// Reads the events of a scenario, [[event]]: changes in flight and their times. See
/// docs/events.md.
#pragma once

#include <vector>

#include "sightline/ocp/event.hpp"
#include "sightline/scenario/read_coupling.hpp"

namespace sightline {

/// `simulation.signal`: the messages that events may wait for, in the order of their times.
/// Messages that the simulation does not send come last, at infinity.
std::vector<TimedSignal> read_signals(const TomlTable& simulation);

/// Reads all of [[event]], for the team and its presence at the start. Rejects every fault that is
/// known without a flight.
Script read_events(const TomlTable& root, const Scenario& scenario, const Observers& observers);

}  // namespace sightline
