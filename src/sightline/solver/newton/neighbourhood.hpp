/// The pairs of a swarm that come near each other, and their potential along the horizon.
///
/// A pair counts where the present plan brings it nearer than the radius at any stage, not only where it is so now:
/// the potential is negligible at the radius, so a pair that appears or disappears causes no jump. Of a pair those
/// stretches of eight stages count in which it comes nearer than the radius. Numbers of an agent stand in rows along the
/// horizon, so lanes are stages and nothing is gathered pair by pair.
#pragma once

#include <span>
#include <vector>

#include "sightline/base/grid.hpp"
#include "sightline/solver/kernels/pose_potential.hpp"
#include "sightline/solver/newton/layout.hpp"
#include "sightline/solver/newton/points.hpp"

namespace sightline {

/// Arrays s, c, z, y are those of the layout. Memory is taken when it is made, none afterwards.
class Neighbourhood {
 public:
  struct Pair {
    int a, b;           ///< places in the swarm's list of agents
    double distance_2;  ///< least along the horizon, squared [m^2]
  };

  /// @param swarm, layout  outlive it
  Neighbourhood(const SwarmPotential& swarm, const Layout& layout, KernelChoice choice);

  /// The pairs that are near along s; if there are more than fit, the nearest.
  void find(const double* s) noexcept;
  /// Those pairs, in the order of (a, b), a < b.
  std::span<const Pair> pairs() const { return pairs_; }
  /// Pairs of the last `find` for which there was no room.
  int left_out() const { return left_out_; }

  /// c += gradients and own Hessians of all pairs, times h.
  void evaluate(const double* s, double* c) noexcept;
  /// y += C z, with the Hessian blocks of the last `evaluate`.
  void product(const double* z, double* y) const noexcept;
  /// of_agents += what the pairs of each agent cost along the horizon, times h.
  void values(const double* s, std::span<double> of_agents) noexcept;

 private:
  using L = NativeLane;
  static constexpr int W = L::width;
  static constexpr int inputs = PosePotential::relative_size, outputs = inputs + inputs * (inputs + 1) / 2;

  static constexpr int stretch = row_quantum;  // stages, whatever the width of a lane

  /// Eight stages of a pair.
  struct Stretch {
    int a, b, stage;
  };

  int agents() const { return static_cast<int>(swarm_.agents.size()); }
  void collect(const double* s, Rows& rows) const noexcept;
  double least_distance_2(int a, int b, int begin, int end) const noexcept;
  void offer(const Pair& pair) noexcept;
  void find_stretches() noexcept;
  template <class F>
  void each_pair_of_stretches(F&& f) noexcept;

  const SwarmPotential& swarm_;
  const Layout& layout_;
  PackFormula<W> value_, derivatives_;
  int n_;     // numbers of a pose that are seen: 3 or 5
  int rows_;  // stages, whole packs

  Grid grid_;
  std::vector<Vec3<double>> centres_;
  std::vector<double> extents_;
  std::vector<Pair> pairs_;
  std::vector<Stretch> stretches_;  // of one pair after the other
  int left_out_ = 0;

  Rows poses_;            // (n x agents)  [stage]
  mutable Rows z_, y_;    // (n x agents)  [stage], of the product
  Rows sums_;             // (n + n (n + 1) / 2 x agents)  [stage]
  Rows H_;                // [stretch][entry][stage]
  Rows in_, out_, cost_;  // of one pair, [pack][entry][lane]
};

}  // namespace sightline
