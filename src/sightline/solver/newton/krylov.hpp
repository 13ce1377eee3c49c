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

#include <chrono>

#include "sightline/solver/continuation/gmres.hpp"
#include "sightline/solver/newton/coupling.hpp"
#include "sightline/solver/newton/groups.hpp"
#include "sightline/solver/newton/influence.hpp"
#include "sightline/solver/newton/phase_schedule.hpp"

namespace sightline {

/// Where there is no time left, iterations end early: one that began is done, none begins past it.
struct Deadline {
  std::chrono::steady_clock::time_point at{};
  bool holds = false;
  bool passed() const noexcept { return holds && std::chrono::steady_clock::now() >= at; }
};

/// What a step has in common with the one before it.
enum class WarmStart {
  none,
  of_updates,   ///< what the couplings add changes from update to update, as far as it did last time
  of_attempts,  ///< the same step, with other limits active
};

class Krylov {
 public:
  /// @param couplings  those it will be given; with swarms, a team that is not mutual is left to GMRES
  /// @param threads  of the crew it will be given
  Krylov(const Layout& layout, const InfluenceGraph& graph, const Couplings& couplings, int threads,
         int max_iterations, double stop);

  /// What a step came to: the team's inputs change by du + by along, which whoever goes over them next adds.
  struct Completion {
    int iterations = 0;
    const double* along = nullptr;  ///< none: du is all
    double by = 0.0;
  };
  /// Completes a step of all agents by themselves, du and ds, to the team's.
  /// @param likeness  substitution begins with what the couplings added to a step that was like this one
  /// @param begun  all groups have begun their first iteration for this step
  Completion complete(Groups& groups, const Couplings& couplings, double* du, double* ds, ThreadPool& pool,
                      WarmStart warm_start = WarmStart::none, const Deadline& deadline = {},
                      bool begun = false) noexcept;

  /// Whether a team's first iteration can be taken group by group before complete() is called: first the direction, once the group
  /// and its neighbours have their own steps; then its image, once they have their directions.
  bool can_begin(const Couplings& couplings) const noexcept {
    return kind_ == Influence::mutual && !couplings.has_swarms() && max_iterations_ > 0;
  }
  void begin_direction(int group, Groups& groups, const Couplings& couplings, const double* ds) noexcept;
  void begin_image(int group, const Couplings& couplings) noexcept;

  /// No step was before: the next is completed as the first was.
  void forget() noexcept { share_ = 0.0, has_added_ = false; }

 private:
  /// What a step is made of and by whom.
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

  /// Groups whose robots take their turn together.
  struct Turn {
    std::vector<int> groups{};
    bool feels = false;                                  // any of its robots another
    bool is_felt = false;                                // any that feels another, by any other
    std::vector<std::vector<std::vector<int>>> wakes{};  // [group][lane]: turns of those that feel that robot
  };

  Layout layout_;
  Influence kind_;
  PhaseSchedule schedule_;  // a direction, and its image
  std::vector<Turn> turns_;
  bool goes_on_ = false;  // what a robot feels is felt by others: else one visit to each turn is all
  std::vector<char> due_, visited_;
  Rows added_;          // by the couplings to ds in the last substitution; grows old where there was none
  double share_ = 0.0;  // of it that came back in the one after
  bool has_added_ = false;
  std::vector<double> of_groups_, curvature_;  // summands, which are added in order
  std::vector<double> changes_;                // of each robot's own cost, [group][lane]
  int max_iterations_;
  double stop_;
  Gmres gmres_;
  Rows s_vectors_, u_vectors_;
};

}  // namespace sightline
