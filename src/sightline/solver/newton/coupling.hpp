/// All potentials of a team along the horizon: their gradients and Hessians for each agent, and the product
/// with the blocks that couple two agents.
///
/// Everything is in the space of what is seen (s): the arrays of `Layout`. A mask is a missing row: an agent
/// that does not feel a potential has none of its gradient, Hessian or coupling block, (9), (10).
#pragma once

#include <memory>
#include <span>

#include "sightline/ocp/ocp.hpp"
#include "sightline/solver/kernels/kernel_table.hpp"
#include "sightline/solver/kernels/pose_potential.hpp"
#include "sightline/solver/newton/layout.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

class Couplings {
 public:
  virtual ~Couplings() = default;

  /// Time [s] and Sight (8) of a body that is not controlled, at stage k.
  virtual void set_time(int k, double t) noexcept = 0;
  /// Time of the update [s]: the weights have the part of it all along the horizon.
  virtual void set_weights(double t) noexcept = 0;
  virtual void set_body(int body, int k, const Sight<double>& sight) noexcept = 0;

  /// Takes the pairs of swarms that come near each other along s for those that count from now on.
  virtual void find_neighbours(const double* s) noexcept = 0;
  /// Pairs that count, and pairs that should but found no room.
  virtual Neighbours neighbours() const noexcept = 0;

  /// Gradients and Hessians of all potentials, times h, at s; c is overwritten.
  virtual void evaluate(const double* s, double* c) noexcept = 0;
  /// Each potential's sum along the horizon, times h, at s; one number for each entry of the list it was made
  /// of.
  virtual void values(const double* s, std::span<double> sums) noexcept = 0;
  /// of_agents += what the pairs of each agent's swarms cost along the horizon, times h, at s.
  virtual void swarm_values(const double* s, std::span<double> of_agents) noexcept = 0;
  /// y = C z, with the Hessian blocks of the last `evaluate`.
  virtual void product(const double* z, double* y) const noexcept = 0;
  /// The rows of one group alone, of a team without swarms.
  virtual void product(int group, const double* z, double* y) const noexcept = 0;
};

std::unique_ptr<Couplings> make_couplings(std::span<const BodyPotential> pairs, const Layout& layout,
                                          int bodies, KernelChoice choice,
                                          std::span<const SwarmPotential> swarms = {});

}  // namespace sightline
