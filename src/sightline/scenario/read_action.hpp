/// What an event of a scenario does: `remove`, `add`, `retune`, `reference` or `observe` of [[event]].
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "sightline/scenario/read_trigger.hpp"

namespace sightline {

/// A coupling as an event adds it, `add = { couple = {...} }`, and a constraint likewise.
Coupling read_added_coupling(const TomlTable& couple, const EventScope& scope);
Constraint read_added_constraint(const TomlTable& constrain, const EventScope& scope);

/// Whether the key of an event says an action.
bool is_action(std::string_view key);

/// The actions under one such key: one, or an array of them.
std::vector<Action> read_actions(const TomlTable& event, std::string_view key, const EventScope& scope);

}  // namespace sightline
