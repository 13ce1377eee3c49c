/// Reads couplings of a scenario: [[couple]], between two bodies, and [[keep_apart]], between all
/// nearby robots.
#pragma once

#include <string_view>
#include <vector>

#include "sightline/scenario/read_part.hpp"

namespace sightline {

/// The robots of a scenario in the order of the team, each with the sensors it has.
using Observers = std::vector<Observer>;

/// The observer that a body is; one that is not controlled has no sensor.
Observer observer_of(const Team& team, const Observers& observers, BodyId body);

/// The body that is named at place `i` of the array under `key`.
BodyId body_named(const TomlTable& at, std::string_view key, std::size_t i, std::string_view name,
                  const Team& team);

/// The bodies named in the array under `key`.
std::vector<BodyId> bodies_named(const TomlTable& at, std::string_view key, std::size_t length,
                                 const Team& team);

/// `name` of a coupling or constraint, by which events refer to it; empty if it has none.
std::string read_term_name(const TomlTable& at);
/// The same; without a name its place, "couple[0]".
std::string name_or_place(const TomlTable& at);

/// `name`, `potential`, `weight`, `between`, `felt_by` and `sensor` of [[couple]]. Without `felt_by`,
/// the coupling acts on all its robots.
Coupling read_coupling(const TomlTable& at, const Team& team, const Observers& observers);

/// One [[couple]].
void read_couple(const TomlTable& at, const Observers& observers, Team& team);

/// Reads [[keep_apart]]: a potential between all pairs of some robots that are near each other.
///
///   agents     "all", or names of at least two robots
///   radius     [m]; 2.5
///   potential  as in [[couple]], of the difference of two poses
///   weight     1
///   pairs_max  capacity for simultaneous pairs, 1 to 100000; default all pairs, at most
///              max(2000, 30 times the number of robots)
void read_keep_apart(const TomlTable& at, Team& team);

}  // namespace sightline
