/// Who influences whom: an arrow leads from a robot that is seen to the one that feels it.
#pragma once

#include <span>
#include <vector>

#include "sightline/solver/kernels/pose_potential.hpp"

namespace sightline {

/// Kinds of influence graphs.
enum class Influence {
  none,     ///< no two agents are coupled
  mutual,   ///< every coupling is felt by both: the optimum of one function
  cascade,  ///< one-sided and without a cycle
  cyclic,   ///< anything else
};

struct InfluenceGraph {
  Influence kind = Influence::none;
  int depth = 0;                            ///< arrows of the longest path of a cascade
  std::vector<int> depth_of{};              ///< of each agent of a cascade: arrows of the longest path to it
  std::vector<std::vector<int>> feelers{};  ///< of each agent: those that feel it, in order
  /// All agents, in the order of the team where all couplings are felt by both. In a cascade whoever is seen stands before
  /// those that feel it; where there are cycles, next is the one that feels the fewest of those that are left.
  std::vector<int> order{};
};

InfluenceGraph influence_graph(std::span<const BodyPotential> potentials, int agents,
                               std::span<const SwarmPotential> swarms = {});

}  // namespace sightline
