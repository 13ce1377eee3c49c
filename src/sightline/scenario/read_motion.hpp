/// What a scenario says of a target or an obstacle: [target.NAME], [obstacle.NAME].
#pragma once

#include <functional>

#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// A target or an obstacle as its section says it.
struct UncooperativeStart {
  UncooperativeBody uncooperative;  ///< its body not yet set
  Vec3<double> p, v;                ///< [m], [m/s]
};

/// @param agent  the robot that a table names under `agent`
UncooperativeStart read_uncooperative(const TomlTable& at,
                                      const std::function<AgentId(const TomlTable&)>& agent);

/// How it moves and what is known of it, in a few words.
std::string in_words(const UncooperativeBody& uncooperative, const Team& team);

}  // namespace sightline
