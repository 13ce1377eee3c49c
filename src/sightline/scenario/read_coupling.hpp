/// Couplings of a scenario: [[couple]], one between two bodies, and [[keep_apart]], between all that are near.
#pragma once

#include <string_view>
#include <vector>

#include "sightline/scenario/read_part.hpp"

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
/// The same; of one that has none its place, "couple[0]".
std::string name_or_place(const TomlTable& at);

/// `name`, `potential`, `weight`, `between` and `felt_by` of [[couple]]; without `felt_by` all its robots feel it.
Coupling read_coupling(const TomlTable& at, const Team& team, const Observers& observers);

/// One [[couple]].
void read_couple(const TomlTable& at, const Observers& observers, Team& team);

/// [[keep_apart]]: a potential between all pairs of some robots that are near each other.
///
///   agents     "all", or names of at least two robots
///   radius     [m]; 2.5
///   potential  as in [[couple]], of the difference of two poses
///   weight     1
///   pairs_max  room for pairs at one time, 1 to 100000; all there can be, but at most 2000 or 30 a robot
void read_keep_apart(const TomlTable& at, Team& team);

}  // namespace sightline
