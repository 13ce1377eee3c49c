/// Combines the steps of single agents to a step of the team: (P + C) y = b, with P solved exactly
/// per agent and C the coupling.
///
///   mutual             conjugate gradients in the null space of the dynamics, preconditioned by P
///   one-sided, acyclic substitution: observed agents before the agents that depend on them
///   otherwise          repeated substitution (block Gauss-Seidel); if it diverges, or with swarms,
///                      GMRES on (1 + P^-1 C) y = P^-1 b
///
/// All iterate in the poses (s); the inputs follow. docs/equations.md, 11.
#pragma once

#include <chrono>

#include "sightline/solver/newton/coupling.hpp"
#include "sightline/solver/newton/groups.hpp"
#include "sightline/solver/newton/influence.hpp"
#include "sightline/solver/newton/phase_schedule.hpp"
#include "sightline/solvers.hpp"

namespace sightline {

/// Deadline of iterations: an iteration in progress is completed, none starts after the deadline.
struct Deadline {
  std::chrono::steady_clock::time_point at{};
  bool holds = false;
  bool passed() const noexcept { return holds && std::chrono::steady_clock::now() >= at; }
};

/// Relation of a step to the previous one.
enum class WarmStart {
  none,
  of_updates,   ///< the coupling correction changes from update to update as much as it did before
  of_attempts,  ///< the same step with another active set
};

class Krylov {
 public:
  /// @param couplings  those passed to complete(); with swarms, a non-mutual team uses GMRES
  /// @param threads    of the thread pool passed to complete()
  Krylov(const Layout& layout, const InfluenceGraph& graph, const Couplings& couplings, int threads,
         int max_iterations, double stop);

  /// Result of a step: the inputs change by du + by along; the next pass over du adds the second
  /// term.
  struct Completion {
    int iterations = 0;
    const double* along = nullptr;  ///< null: du is complete
    double by = 0.0;
  };
  /// Completes the uncoupled steps du and ds of all agents to the step of the team.
  /// @param warm_start  substitution starts with the coupling correction of a similar step
  /// @param begun       all groups have begun their first iteration for this step
  Completion complete(Groups& groups, const Couplings& couplings, double* du, double* ds, ThreadPool& pool,
                      WarmStart warm_start = WarmStart::none, const Deadline& deadline = {},
                      bool begun = false) noexcept;

  /// Whether the first iteration can run group by group before complete(): first the direction,
  /// once the group and its neighbours have their own steps; then its image, once they have their
  /// directions.
  bool can_begin(const Couplings& couplings) const noexcept {
    return kind_ == Influence::mutual && !couplings.has_swarms() && max_iterations_ > 0;
  }
  void begin_direction(int group, Groups& groups, const Couplings& couplings, const double* ds) noexcept;
  void begin_image(int group, const Couplings& couplings) noexcept;

  /// Discards the previous correction: the next step is completed without a warm start.
  void forget() noexcept { share_ = 0.0, has_added_ = false; }

 private:
  /// Arguments of one complete().
  struct Work {
    Groups& groups;
    const Couplings& couplings;
    double *du, *ds;
    ThreadPool& pool;
    WarmStart warm_start;
    Deadline deadline;
    bool begun;
  };

  Completion conjugate_gradients(const Work& work) noexcept;
  int substitute(const Work& work) noexcept;
  double take_turn(int turn, const Work& work) noexcept;
  int general(const Work& work) noexcept;
  void direct(int group, Groups& groups, const double* r, double* z_u, double* z) noexcept;
  void bend(int group, const double* w, const double* Cp, const double* z) noexcept;
  void guess(const Work& work) noexcept;
  void remember(const Work& work) noexcept;

  /// Groups whose robots are updated together.
  struct Turn {
    std::vector<int> groups{};
    bool feels = false;                                  // any of its robots depends on another
    bool is_felt = false;                                // any robot depends on one of its dependent robots
    std::vector<std::vector<std::vector<int>>> wakes{};  // [group][lane]: turns that depend on that robot
  };

  Layout layout_;
  Influence kind_;
  PhaseSchedule<2> schedule_;  // phases: a direction, and its image
  std::vector<Turn> turns_;
  bool goes_on_ = false;  // a dependent robot has dependents; otherwise each turn is visited once
  std::vector<char> due_, visited_;
  Rows added_;          // coupling correction to ds of the last substitution; unchanged if there was none
  double share_ = 0.0;  // fraction of it that recurred in the next substitution
  bool has_added_ = false;
  std::vector<double> of_groups_, curvature_;  // summands, added in fixed order
  std::vector<double> changes_;                // of each robot's own cost, [group][lane]
  int max_iterations_;
  double stop_;
  Gmres gmres_;
  Rows s_vectors_, u_vectors_;
};

}  // namespace sightline
