/// Reads targets and obstacles, [target.NAME] and [obstacle.NAME].
#pragma once

#include <functional>

#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// A target or an obstacle as its section defines it.
struct UncooperativeStart {
  UncooperativeBody uncooperative;  ///< its body is not yet set
  Vec3<double> p, v;                ///< [m], [m/s]
};

/// @param agent  finds the robot that a table names under `agent`
UncooperativeStart read_uncooperative(const TomlTable& at,
                                      const std::function<AgentId(const TomlTable&)>& agent);

/// A short description of its motion and of what the robots assume about it.
std::string describe(const UncooperativeBody& uncooperative, const Team& team);

}  // namespace sightline
