/// Influence graph of a team: an edge leads from an observed robot to the robot on which the
/// coupling acts.
#pragma once

#include <span>
#include <vector>

#include "sightline/kernels.hpp"

namespace sightline {

/// Kinds of influence graphs.
enum class Influence {
  none,     ///< no two agents are coupled
  mutual,   ///< every coupling acts on both robots: the optimum of one function
  cascade,  ///< one-sided and without a cycle
  cyclic,   ///< anything else
};

struct InfluenceGraph {
  Influence kind = Influence::none;
  int depth = 0;                            ///< edges of the longest path of a cascade
  std::vector<int> depth_of{};              ///< per agent of a cascade: edges of the longest path to it
  std::vector<std::vector<int>> feelers{};  ///< per agent: agents on which couplings with it act, in order
  /// All agents, in team order if all couplings are mutual. In a cascade an observed agent precedes
  /// the agents that depend on it; with cycles, the agent with the fewest unresolved dependencies
  /// is next.
  std::vector<int> order{};
};

InfluenceGraph influence_graph(std::span<const BodyPotential> potentials, int agents,
                               std::span<const SwarmPotential> swarms = {});

}  // namespace sightline
