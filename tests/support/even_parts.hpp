/// A chain in parts of one size, or nearly.
#pragma once

#include "sightline/solvers.hpp"

namespace sightline {

/// Neighbours of the chain together, as many parts as are asked for.
inline Partition even_parts(const Team& team, int parts) {
  Partition partition(static_cast<std::size_t>(parts));
  const int robots = static_cast<int>(team.agents().size());
  for (int i = 0; i < robots; ++i)
    partition[static_cast<std::size_t>(i * parts / robots)].push_back(AgentId{{i}});
  return partition;
}

}  // namespace sightline
