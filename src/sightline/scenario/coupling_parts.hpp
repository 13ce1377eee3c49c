/// Couplings of a scenario: [[couple]], one between two bodies.
#pragma once

#include <string_view>
#include <vector>

#include "sightline/scenario/scenario_parts.hpp"

namespace sightline {

/// The robots of a scenario in the order of the team, each with the sensor it has.
using Observers = std::vector<Observer>;

/// What a body is as an observer; one that is not controlled has no sensor.
Observer observer_of(const Team& team, const Observers& observers, BodyId body);

/// The body that is named at place `i` of the array under `key`.
BodyId body_named(const TomlTable& at, std::string_view key, std::size_t i, std::string_view name,
                  const Team& team);

/// The bodies named in the array under `key`.
std::vector<BodyId> bodies_named(const TomlTable& at, std::string_view key, std::size_t length,
                                 const Team& team);

/// `name` of a coupling or constraint, by which events speak of it; empty where it has none.
std::string read_term_name(const TomlTable& at);

/// `name`, `potential`, `weight`, `between` and `felt_by` of [[couple]]; without `felt_by` all its robots feel it.
Coupling read_coupling(const TomlTable& at, const Team& team, const Observers& observers);

/// One [[couple]].
void read_couple(const TomlTable& at, const Observers& observers, Team& team);

}  // namespace sightline
