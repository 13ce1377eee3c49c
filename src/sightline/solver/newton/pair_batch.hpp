/// Equal potentials over many pairs of bodies: one formula at all stages of all pairs.
#pragma once

#include <vector>

#include "sightline/solver/kernels/pose_potential.hpp"
#include "sightline/solver/newton/layout.hpp"
#include "sightline/solver/newton/points.hpp"

namespace sightline {

/// What potentials see beside the agents, stage by stage.
struct StageParameters {
  Rows bodies;       ///< Sights of bodies that are not controlled  (10 bodies x N)
  Rows time;         ///< [s]  (1 x N)
  Rows uncertainty;  ///< Sight::uncertainty [m]  (bodies x N)
};

/// Arrays s, c, z, y are those of the layout.
struct PairBatch {
  std::vector<const BodyPotential*> pairs;
  Points points;  ///< stage by stage of the first pair, then of the next

  /// Whether this pair has the batch's formula and is felt as its pairs are.
  bool suits(const BodyPotential& pair) const;
  /// The points' inputs at s.
  void gather(const Layout& layout, const StageParameters& parameters, const double* s) noexcept;
  /// The value of each pair that is wanted, added up along the horizon at s, into sums[pair - first].
  /// @param wanted  as `sums`, what is 0 stays as it is; empty: all
  void sum_values(const Layout& layout, const StageParameters& parameters, const double* s,
                  const BodyPotential* first, std::span<double> sums, std::span<const char> wanted) noexcept;
  /// c += gradients and own Hessians of the last `derive`, of potentials that are not relative.
  void scatter(const Layout& layout, double* c) const noexcept;

 private:
  void gather(const BodyPotential& pair, int point, const Layout& layout, const StageParameters& parameters,
              const double* s) noexcept;
};

}  // namespace sightline
