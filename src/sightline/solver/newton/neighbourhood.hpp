/// Pairs of a swarm that approach each other, and their potential along the horizon.
///
/// A pair is active if the present plan brings it within the radius at any stage, not only now. The
/// potential is negligible at the radius, so an appearing or disappearing pair causes no jump. Only
/// the stretches of eight stages within the radius are evaluated. An agent's numbers form rows
/// along the horizon, so lanes are stages and no pair needs a gather.
#pragma once

#include <span>
#include <vector>

#include "sightline/base/grid.hpp"
#include "sightline/kernels.hpp"
#include "sightline/solver/newton/layout.hpp"
#include "sightline/solver/newton/points.hpp"

namespace sightline {

/// Arrays s, c, z, y follow the layout. The constructor allocates all memory.
class Neighbourhood {
 public:
  struct Pair {
    int a, b;           ///< indices in the swarm's list of agents
    double distance_2;  ///< squared minimum distance along the horizon [m^2]
  };

  /// @param swarm, layout  must outlive the object
  Neighbourhood(const SwarmPotential& swarm, const Layout& layout, KernelChoice choice);

  /// Finds the pairs within the radius along s; beyond the capacity, keeps the nearest.
  void find(const double* s) noexcept;
  /// Pairs of the last `find`, by (a, b), a < b.
  std::span<const Pair> pairs() const { return pairs_; }
  /// Pairs of the last `find` beyond the capacity.
  int left_out() const { return left_out_; }

  /// c += gradients and own Hessians of all pairs, times h.
  void evaluate(const double* s, double* c) noexcept;
  /// y += C z, with the Hessian blocks of the last `evaluate`.
  void product(const double* z, double* y) const noexcept;
  /// of_agents += cost of each agent's pairs along the horizon, times h.
  void values(const double* s, std::span<double> of_agents) noexcept;

 private:
  using L = NativeLane;
  static constexpr int W = L::width;
  static constexpr int inputs = PosePotential::relative_size, outputs = inputs + inputs * (inputs + 1) / 2;

  static constexpr int stretch = row_quantum;  // stages, independent of the lane width

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
  int n_;     // numbers of a pose in use: 3 or 5
  int rows_;  // stages, whole packs

  Grid grid_;
  std::vector<Vec3<double>> centres_;
  std::vector<double> extents_;
  std::vector<Pair> pairs_;
  std::vector<Stretch> stretches_;  // grouped by pair
  int left_out_ = 0;

  Rows poses_;            // (n x agents)  [stage]
  mutable Rows z_, y_;    // (n x agents)  [stage], of the product
  Rows sums_;             // (n + n (n + 1) / 2 x agents)  [stage]
  Rows H_;                // [stretch][entry][stage]
  Rows in_, out_, cost_;  // buffers of one pair, [pack][entry][lane]
};

}  // namespace sightline
