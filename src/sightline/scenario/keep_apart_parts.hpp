/// [[keep_apart]]: a potential between all pairs of some robots that are near each other.
///
///   agents     "all", or names of at least two robots
///   radius     [m]; 2.5
///   potential  as in [[couple]], of the difference of two poses
///   weight     1
///   pairs_max  room for pairs at one time, 1 to 20000; all there can be, but at most 2000
#pragma once

#include "sightline/ocp/team.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

void read_keep_apart(const TomlTable& at, Team& team);

}  // namespace sightline
