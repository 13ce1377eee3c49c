/// From steps of single agents to a step of the team: (P + C) y = b, where P is solved exactly agent by agent
/// and C couples them.
///
///   felt by both sides      conjugate gradients in the null space of the dynamics, preconditioned by P
///   felt one-sided, no cycle   y <- y - P^-1 C dy: exact after as many iterations as the influence graph is deep
///   anything else            GMRES on (1 + P^-1 C) y = P^-1 b
///
/// All three iterate in the poses (s); the inputs follow. docs/equations.md, 11.
#pragma once

#include "sightline/solver/continuation/gmres.hpp"
#include "sightline/solver/newton/coupling.hpp"
#include "sightline/solver/newton/groups.hpp"

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
  int depth = 0;                ///< arrows of the longest path of a cascade
  std::vector<int> depth_of{};  ///< of each agent of a cascade: arrows of the longest path to it
};

InfluenceGraph influence_graph(std::span<const BodyPotential> potentials, int agents,
                               std::span<const SwarmPotential> swarms = {});

class Krylov {
 public:
  Krylov(const Layout& layout, const InfluenceGraph& graph, int max_iterations, double stop);

  /// Completes a step of all agents by themselves, du and ds, to the team's. @return iterations
  int complete(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept;

 private:
  int conjugate_gradients(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept;
  int sweeps(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept;
  int general(Groups& groups, const Couplings& couplings, double* du, double* ds) noexcept;

  Layout layout_;
  InfluenceGraph graph_;
  int max_iterations_;
  double stop_;
  Gmres gmres_;
  Rows s_vectors_, u_vectors_;
};

}  // namespace sightline
