/// Pairs of near points among many, by a hash grid whose cells are as wide as the reach.
///
///   all (i, j), i < j, with |p_i - p_j| < reach, in the order of (i, j)
///
/// A counting sort puts each point into a table slot by its cell, floor(p / reach). The search
/// covers the 27 cells around a point. All cells beyond 2^20 on a side are one cell, so no near
/// pair is missed at any distance. A point that is not finite is near no other.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

class Grid {
 public:
  /// Allocates for this many points; nothing is allocated afterwards.
  explicit Grid(int points);

  /// Calls f(i, j) for each near pair.
  /// @param p  at most as many points as allocated
  template <class F>
  void each_pair(std::span<const Vec3<double>> p, double reach, F&& f) noexcept {
    sort(p, reach);
    for (int i = 0; i < static_cast<int>(p.size()); ++i) {
      const std::span<const int> later = near_and_later(p, i, reach);
      for (const int j : later) f(i, j);
    }
  }

 private:
  using Cell = std::array<std::int32_t, 3>;

  void sort(std::span<const Vec3<double>> p, double reach) noexcept;
  std::span<const int> near_and_later(std::span<const Vec3<double>> p, int i, double reach) noexcept;
  std::size_t slot(const Cell& cell) const;

  std::vector<Cell> cells_;  // of each point
  std::vector<int> begin_;   // of each slot in sorted_, and the end
  std::vector<int> sorted_, found_;
};

}  // namespace sightline
