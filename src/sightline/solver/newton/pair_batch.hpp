/// Batch of equal potentials over many pairs of bodies: one formula at all stages of all pairs.
#pragma once

#include <vector>

#include "sightline/kernels.hpp"
#include "sightline/solver/newton/layout.hpp"
#include "sightline/solver/newton/points.hpp"

namespace sightline {

/// Inputs of potentials besides the agents, stage by stage.
struct StageParameters {
  Rows bodies;       ///< Sights of uncontrolled bodies  (10 bodies x N)
  Rows time;         ///< [s]  (1 x N)
  Rows uncertainty;  ///< Sight::uncertainty [m]  (bodies x N)
};

/// Arrays s, c, z, y follow the layout.
struct PairBatch {
  std::vector<const BodyPotential*> pairs;
  Points points;  ///< stage by stage of the first pair, then of the next

  /// Whether the pair has the batch's formula and acts on the same ends.
  bool suits(const BodyPotential& pair) const;
  /// Writes the points' inputs at s.
  void gather(const Layout& layout, const StageParameters& parameters, const double* s) noexcept;
  /// Sums the value of each wanted pair along the horizon at s into sums[pair - first].
  /// @param wanted  as `sums`; entries with 0 are unchanged; empty: all
  void sum_values(const Layout& layout, const StageParameters& parameters, const double* s,
                  const BodyPotential* first, std::span<double> sums, std::span<const char> wanted) noexcept;
  /// c += gradients and own Hessians of the last `derive`, for non-relative potentials.
  void scatter(const Layout& layout, double* c) const noexcept;

 private:
  void gather(const BodyPotential& pair, int point, const Layout& layout, const StageParameters& parameters,
              const double* s) noexcept;
};

}  // namespace sightline
