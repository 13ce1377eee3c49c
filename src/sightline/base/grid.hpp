/// Which points of many are near each other, by cells as wide as they may be apart.
///
///   all (i, j), i < j, with |p_i - p_j| < reach, in the order of (i, j)
///
/// Points are counted into the slots of a table by their cell's number, floor(p / reach), and looked for in the 27
/// cells around. Cells beyond 2^20 to either side are one: nothing near is missed, however far out. A point that is
/// not finite is near none.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/base/fixed.hpp"

namespace sightline {

class Grid {
 public:
  /// Room for that many points; nothing is allocated afterwards.
  explicit Grid(int points);

  /// f(i, j) for each pair that is near. @param p  as many points as there is room for, or fewer
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
