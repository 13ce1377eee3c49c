/// Reads and describes the events of a scenario, [[event]]: changes in flight and their times. See
/// docs/events.md.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/events.hpp"
#include "sightline/scenario/read_coupling.hpp"

namespace sightline {

/// `simulation.signal`: the messages that events may wait for, in the order of their times.
/// Messages that the simulation does not send come last, at infinity.
std::vector<TimedSignal> read_signals(const TomlTable& simulation);

/// Reads all of [[event]], for the team and its presence at the start. Rejects every fault that is
/// known without a flight.
Script read_events(const TomlTable& root, const ScenarioSpec& scenario, const Observers& observers);

/// The kinds of faults by their words, in the order of Surroundings::FaultKind.
inline constexpr std::array<std::string_view, 3> fault_words = {"dropout", "freeze", "jump"};

/// An event as a text for the user: its name, its trigger, its changes.
std::string describe(const TeamEvent& event, const Team& all);
std::string describe(const Action& action, const Team& all);

}  // namespace sightline
