/// From steps of single agents to a step of the team: (P + C) y = b, where P is solved exactly agent by agent
/// and C couples them.
///
///   felt by both sides      conjugate gradients in the null space of the dynamics, preconditioned by P
///   felt one-sided, no cycle   substitution: whoever is seen before those that feel it
///   anything else            the same, again and again (block Gauss-Seidel); where that does not settle, and with swarms,
///                            GMRES on (1 + P^-1 C) y = P^-1 b
///
/// All iterate in the poses (s); the inputs follow. docs/equations.md, 11.
#pragma once

#include "sightline/solver/continuation/gmres.hpp"
#include "sightline/solver/newton/coupling.hpp"
#include "sightline/solver/newton/groups.hpp"
#include "sightline/solver/newton/influence.hpp"

namespace sightline {

class Krylov {
 public:
  /// @param has_swarms  then a team that is not mutual is left to GMRES
  Krylov(const Layout& layout, const InfluenceGraph& graph, int max_iterations, double stop,
         bool has_swarms = false);

  /// Completes a step of all agents by themselves, du and ds, to the team's. @return iterations
  int complete(Groups& groups, const Couplings& couplings, double* du, double* ds, Crew& crew) noexcept;

 private:
  /// What a step is made of and by whom.
  struct Work {
    Groups& groups;
    const Couplings& couplings;
    double *du, *ds;
    Crew& crew;
  };
  /// One group's rows in the arrays, whole packs.
  struct Span {
    std::ptrdiff_t first;
    int length;
  };

  int conjugate_gradients(const Work& work) noexcept;
  int substitute(const Work& work) noexcept;
  double take_turn(int turn, const Work& work) noexcept;
  int general(const Work& work) noexcept;
  Span s_of(int group) const noexcept;
  Span u_of(int group) const noexcept;
  double sum_of_groups() const noexcept;

  /// Groups whose robots take their turn together.
  struct Turn {
    std::vector<int> groups{};
    bool feels = false;                                  // any of its robots another
    bool is_felt = false;                                // by any other
    std::vector<std::vector<std::vector<int>>> wakes{};  // [group][lane]: turns of those that feel that robot
  };

  Layout layout_;
  Influence kind_;
  std::vector<Turn> turns_;
  std::vector<char> due_;
  std::vector<double> of_groups_;  // summands, which are added in order
  std::vector<double> changes_;    // of each robot's own cost, [group][lane]
  int max_iterations_;
  double stop_;
  Gmres gmres_;
  Rows s_vectors_, u_vectors_;
};

}  // namespace sightline
