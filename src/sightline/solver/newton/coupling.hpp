/// All potentials of a team along the horizon: their gradients and Hessians for each agent, and the product
/// with the blocks that couple two agents.
///
/// Everything is in the space of what is seen (s): the arrays of `Layout`. A mask is a missing row: an agent
/// that does not feel a potential has none of its gradient, Hessian or coupling block, (9), (10).
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sightline/base/thread_pool.hpp"
#include "sightline/ocp/ocp.hpp"
#include "sightline/solver/kernels/kernel_table.hpp"
#include "sightline/solver/kernels/pose_potential.hpp"
#include "sightline/solver/newton/layout.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

class Couplings {
 public:
  virtual ~Couplings() = default;

  /// Time [s], and the Sight of a body that is not controlled, at stage k.
  virtual void set_time(int k, double t) noexcept = 0;
  /// Time of the update [s]: the weights have the part of it all along the horizon.
  virtual void set_weights(double t) noexcept = 0;
  /// Sight::doubt of a body at stage k [m]; 0 before it is told.
  virtual void set_uncertainty(int body, int k, double sigma) noexcept = 0;
  virtual void set_body(int body, int k, const Sight<double>& sight) noexcept = 0;

  /// Takes the pairs of swarms that come near each other along s for those that count from now on.
  virtual void find_neighbours(const double* s) noexcept = 0;
  /// Pairs that count, and pairs that should but found no room.
  virtual Neighbours neighbours() const noexcept = 0;

  /// Evaluates all potentials at s. With swarms c, of the whole team, holds what these give, else it is not touched.
  void derive(const double* s, double* c, ThreadPool& pool) noexcept;
  /// The same in two parts: first what is evaluated at once for all groups, if anything is, ...
  virtual bool gathers() const noexcept = 0;
  virtual void gather(const double* s, double* c, ThreadPool& pool) noexcept = 0;
  /// ... then group by group, from what is seen of it and of its neighbours.
  virtual void derive(int group, const double* s) noexcept = 0;
  /// Pairs of groups that potentials couple, but for those of swarms; some more than once, a group with itself too.
  virtual std::vector<std::pair<int, int>> coupled_groups() const = 0;
  /// Gradients and Hessians of what one group feels, times h, of the last `derive`. Without swarms c, the group's own numbers, is
  /// overwritten; with them, it is the group's part of what `derive` was given.
  virtual void take(int group, double* c) const noexcept = 0;
  /// Both, for all groups.
  void evaluate(const double* s, double* c, ThreadPool& pool) noexcept;
  void evaluate(const double* s, double* c) noexcept;
  /// Each potential's sum along the horizon, times h, at s; one number for each entry of the list it was made of.
  /// @param wanted  of each entry whether its number is looked for, the others stay; empty: all are
  virtual void values(const double* s, std::span<double> sums,
                      std::span<const char> wanted = {}) noexcept = 0;
  /// of_agents += what the pairs of each agent's swarms cost along the horizon, times h, at s.
  virtual void swarm_values(const double* s, std::span<double> of_agents) noexcept = 0;
  /// y = C z, with the Hessian blocks of the last `derive`.
  void product(const double* z, double* y) const noexcept;
  /// The rows of one group alone; `add_swarms` adds what swarms give, in all rows at once.
  virtual void product(int group, const double* z, double* y) const noexcept = 0;
  virtual void add_swarms(const double* z, double* y) const noexcept = 0;
  virtual bool has_swarms() const noexcept = 0;

 protected:
  explicit Couplings(const Layout& layout) : layout_(layout) {}
  const Layout layout_;
};

std::unique_ptr<Couplings> make_couplings(std::span<const BodyPotential> pairs, const Layout& layout,
                                          int bodies, KernelChoice choice,
                                          std::span<const SwarmPotential> swarms = {});

}  // namespace sightline
