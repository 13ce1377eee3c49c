/// All potentials of a team along the horizon: gradients and Hessians per agent, and the product
/// with the blocks that couple two agents.
///
/// All arrays are in the space of the coupled Sight components (s), in the order of `Layout`. A
/// mask is a missing row: an agent on which a potential does not act has no gradient, Hessian or
/// coupling block of it, (9), (10).
#pragma once

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/kernels.hpp"
#include "sightline/solver.hpp"
#include "sightline/solver/newton/layout.hpp"
#include "sightline/solver/newton/pair_batch.hpp"
#include "sightline/team.hpp"

namespace sightline {

class Couplings {
 public:
  virtual ~Couplings() = default;

  /// Sets the time [s] of stage k.
  virtual void set_time(int k, double t) noexcept = 0;
  /// Sets the time of the update [s]: it fixes the blending of the weights for the whole horizon.
  virtual void set_weights(double t) noexcept = 0;
  /// Sight::uncertainty of a body at stage k [m]; initially 0. set_body() sets the Sight of an
  /// uncontrolled body.
  virtual void set_uncertainty(int body, int k, double sigma) noexcept = 0;
  virtual void set_body(int body, int k, const Sight<double>& sight) noexcept = 0;

  /// Selects the pairs of swarms that approach each other along s as the active pairs.
  virtual void find_neighbours(const double* s) noexcept = 0;
  /// Number of active pairs, and of pairs beyond the capacity.
  virtual Neighbours neighbours() const noexcept = 0;

  /// Evaluates all potentials at s. With swarms, c (whole team) receives their contribution;
  /// without swarms, c is unchanged.
  void derive(const double* s, double* c, ThreadPool& pool) noexcept;
  /// derive() in two parts: gather() first evaluates what all groups share, if gathers(), ...
  virtual bool gathers() const noexcept = 0;
  virtual void gather(const double* s, double* c, ThreadPool& pool) noexcept = 0;
  /// ... then each group from its own s and that of its neighbours.
  virtual void derive(int group, const double* s) noexcept = 0;
  /// Pairs of groups coupled by potentials, except swarms; may repeat, and may pair a group with
  /// itself.
  virtual std::vector<std::pair<int, int>> coupled_groups() const = 0;
  /// Gradients and Hessians, times h, that act on one group, from the last `derive`. Without swarms
  /// c, the group's own numbers, is overwritten; with swarms c is the group's part of the array
  /// passed to `derive`.
  virtual void take(int group, double* c) const noexcept = 0;
  /// derive() and take() for all groups.
  void evaluate(const double* s, double* c, ThreadPool& pool) noexcept;
  void evaluate(const double* s, double* c) noexcept;
  /// Sum of each potential along the horizon, times h, at s; one number per entry of the list
  /// passed to make_couplings().
  /// @param wanted  per entry: whether its sum is evaluated, else it is unchanged; empty: all
  virtual void values(const double* s, std::span<double> sums,
                      std::span<const char> wanted = {}) noexcept = 0;
  /// of_agents += cost of each agent's swarm pairs along the horizon, times h, at s.
  virtual void swarm_values(const double* s, std::span<double> of_agents) noexcept = 0;
  /// y = C z, with the Hessian blocks of the last `derive`.
  void product(const double* z, double* y) const noexcept;
  /// The rows of one group alone; `add_swarms` adds the swarms' contribution to all rows.
  virtual void product(int group, const double* z, double* y) const noexcept = 0;
  /// The rows of one group of C' z: each coupling then changes the robot that is seen.
  virtual void transposed_product(int group, const double* z, double* y) const noexcept = 0;
  virtual void add_swarms(const double* z, double* y) const noexcept = 0;
  virtual bool has_swarms() const noexcept = 0;
  /// Times, uncertainties and Sights that were set.
  virtual const StageParameters& parameters() const noexcept = 0;

 protected:
  explicit Couplings(const Layout& layout) : layout_(layout) {}
  const Layout layout_;
};

std::unique_ptr<Couplings> make_couplings(std::span<const BodyPotential> pairs, const Layout& layout,
                                          int bodies, KernelChoice choice,
                                          std::span<const SwarmPotential> swarms = {});

}  // namespace sightline
