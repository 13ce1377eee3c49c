/// All agents of a team, grouped by equal models, each group in lanes.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/kernels.hpp"
#include "sightline/solver.hpp"
#include "sightline/solver/newton/coupling.hpp"
#include "sightline/solver/newton/layout.hpp"
#include "sightline/team.hpp"

namespace sightline {

/// Initial damping of a group's lanes.
enum class Damping {
  none,
  last,  ///< the previous factorisation's, for a similar problem
};

/// Arrays follow the layout. Equal agents are distributed over turns of at most eight robots: with
/// n turns, agent a is in turn a mod n. Neighbours of a chain are thus in adjacent turns, at the
/// same lane. A turn is one group, or several if there are fewer lanes.
class Groups {
 public:
  /// @param order  of the agents, for the distribution; empty: that of the team
  Groups(const Ocp& ocp, std::span<const BodyPotential> potentials, KernelChoice choice,
         std::span<const int> order = {});

  const Layout& layout() const { return layout_; }
  /// Kernel use of the robot models.
  const KernelUse& kernels() const { return kernels_; }
  Group& group_of(int agent) { return *groups_[static_cast<std::size_t>(layout_.place(agent).group)]; }
  const Group& group_of(int agent) const {
    return *groups_[static_cast<std::size_t>(layout_.place(agent).group)];
  }

  /// Tilt [-] added to the model's tilt in all later roll-outs; independent of the state.
  void set_lean(int agent, const Vec2<double>& lean) noexcept {
    lean_[static_cast<std::size_t>(agent)] = lean;
  }
  /// Sets an agent's u* (nu) for all later updates.
  void set_u_ref(int agent, const double* u_ref) noexcept;
  /// As Group::hold_reference().
  void hold_reference(int group, bool holds) noexcept {
    groups_[static_cast<std::size_t>(group)]->hold_reference(holds);
  }
  /// Initialises lanes without an agent with the state of an agent of the same model, which is a
  /// valid state.
  /// @param x_at  offset of each agent's states in x
  void rest_at(const double* x, std::span<const int> x_at) noexcept;
  void roll_out(int group, const double* u, double* s) noexcept;
  void roll_out(const double* u, double* s, ThreadPool& pool) noexcept {
    each(pool, [&](int g, int) noexcept { roll_out(g, u, s); });
  }
  void roll_out(const double* u, double* s) noexcept {
    for (int g = 0; g < static_cast<int>(groups_.size()); ++g) roll_out(g, u, s);
  }
  /// Copies a group's states of the last roll-out: agent a of stage k to x + k stage + x_at[a].
  void copy_states(int group, double* x, std::ptrdiff_t stage, std::span<const int> x_at) const noexcept;
  /// Tracking cost, barriers and input-rate cost of a group's agents along the last roll-out, times
  /// h, per lane.
  void own_costs(int group, const double* u, double* of_lanes) noexcept;
  /// Uncoupled step of each agent of a group: factorises at the last roll-out, then runs forward
  /// while the gains are cached. A lane with a pivot below its floor is damped (Levenberg) until
  /// all pivots are valid.
  /// @param c  the group's part
  /// @return whether a lane is damped
  bool solve(int group, const double* u, const double* active, const double* c, double* H_u, double* du,
             double* ds, Damping begins = Damping::none) noexcept;
  /// solve() for all groups, c of the layout.
  void solve(const double* u, const double* active, const double* c, double* H_u, double* du,
             double* ds) noexcept;
  /// One backward sweep of a group, for H_u alone.
  /// @param spare  rows of the size of u, overwritten
  void differentiate(int group, const double* u, const double* active, const double* c, double* H_u,
                     double* spare) noexcept {
    const Layout::Part& part = layout_.groups[static_cast<std::size_t>(group)];
    groups_[static_cast<std::size_t>(group)]->backward(u + part.u, active + part.u, c, H_u + part.u,
                                                       spare + part.u);
  }
  void precondition(int group, const double* r, double* du, double* ds) noexcept {
    const Layout::Part& part = layout_.groups[static_cast<std::size_t>(group)];
    groups_[static_cast<std::size_t>(group)]->precondition(r + part.s, du + part.u, ds + part.s);
  }
  void precondition(const double* r, double* du, double* ds) noexcept {
    for (int g = 0; g < static_cast<int>(groups_.size()); ++g) precondition(g, r, du, ds);
  }
  /// As Group::adjoint() and own_slopes(); y, p and slopes are the group's own.
  void adjoint(int group, const double* g, const double* r, double* du, double* ds, double* y,
               double* p) noexcept {
    const Layout::Part& part = layout_.groups[static_cast<std::size_t>(group)];
    groups_[static_cast<std::size_t>(group)]->adjoint(g + part.u, r != nullptr ? r + part.s : nullptr,
                                                      du + part.u, ds + part.s, y, p);
  }
  void own_slopes(int group, const double* u, const double* du, const double* y,
                  double* slopes) const noexcept {
    const Layout::Part& part = layout_.groups[static_cast<std::size_t>(group)];
    groups_[static_cast<std::size_t>(group)]->own_slopes(u + part.u, du + part.u, y, h_, dt_, slopes);
  }
  /// work(group, thread) for each group, on the thread pool.
  template <class Work>
  void each(ThreadPool& pool, Work&& work) const noexcept {
    pool.share(static_cast<int>(groups_.size()), work);
  }
  /// The agents of a group, lane by lane.
  std::span<const int> members(int group) const { return members_[static_cast<std::size_t>(group)]; }

 private:
  void settle_groups();
  void add_limits(const Group& group, const double* u, int agent, double& cost) noexcept;
  /// Model and barriers of an agent with buffers, and the cost of its input rates.
  struct Limited {
    Model model;
    std::vector<RelaxedBarrier> barriers;
    std::vector<double> x, u;
    std::vector<double> R_rate;
  };

  double h_, dt_;
  Layout layout_;
  KernelUse kernels_;
  std::vector<std::unique_ptr<Group>> groups_;
  Rows memory_;                            // of the groups
  std::vector<std::vector<int>> members_;  // [group][lane]: agent
  std::vector<int> rests_as_;              // [group]: agent whose state initialises lanes without an agent
  std::vector<Limited> limited_;           // [agent]
  std::vector<Vec2<double>> lean_;         // [agent]
};

}  // namespace sightline
