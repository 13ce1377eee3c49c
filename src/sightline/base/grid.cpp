#include "sightline/base/grid.hpp"

#include <bit>
#include <cassert>
#include <cmath>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr double last_cell = 1 << 20;
// Rounding must not place two points that are slightly less than a cell apart two cells apart.
constexpr double wider = 1.0 + 1e-9;

std::int32_t cell_of(double x, double width) {
  const double cell = std::floor(x / width);
  if (!(cell > -last_cell)) return static_cast<std::int32_t>(-last_cell);  // also for NaN
  return static_cast<std::int32_t>(std::min(cell, last_cell));
}

}  // namespace

Grid::Grid(int points)
    : cells_(size(points)),
      begin_(std::bit_ceil(2 * size(points) + 1) + 1),
      sorted_(size(points)),
      found_(size(points)) {}

std::size_t Grid::slot(const Cell& cell) const {
  std::uint64_t key = 0;
  for (const std::int32_t c : cell) key = (key ^ static_cast<std::uint32_t>(c)) * 0x9e3779b97f4a7c15U;
  return static_cast<std::size_t>(key >> 32) & (begin_.size() - 2);
}

void Grid::sort(std::span<const Vec3<double>> p, double reach) noexcept {
  assert(p.size() <= cells_.size() && "there is room for these points");
  const double width = wider * reach;
  std::fill(begin_.begin(), begin_.end(), 0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    cells_[i] = {cell_of(p[i].x, width), cell_of(p[i].y, width), cell_of(p[i].z, width)};
    ++begin_[slot(cells_[i]) + 1];
  }
  for (std::size_t s = 1; s < begin_.size(); ++s) begin_[s] += begin_[s - 1];
  // Backward, so that points of a slot keep their order and `begin_` ends at the starts of the
  // slots.
  for (std::size_t i = p.size(); i-- > 0;) sorted_[size(--begin_[slot(cells_[i]) + 1])] = static_cast<int>(i);
}

std::span<const int> Grid::near_and_later(std::span<const Vec3<double>> p, int i, double reach) noexcept {
  std::size_t n = 0;
  const Cell home = cells_[size(i)];
  for (int around = 0; around < 27; ++around) {
    const Cell cell = {home[0] + around % 3 - 1, home[1] + around / 3 % 3 - 1, home[2] + around / 9 - 1};
    const std::size_t s = slot(cell) + 1;
    const int end = s + 1 < begin_.size() ? begin_[s + 1] : static_cast<int>(p.size());
    for (int at = begin_[s]; at < end; ++at) {
      const int j = sorted_[size(at)];
      if (j <= i || cells_[size(j)] != cell || !(norm(p[size(i)] - p[size(j)]) < reach)) continue;
      found_[n++] = j;
    }
  }
  std::sort(found_.begin(), found_.begin() + static_cast<std::ptrdiff_t>(n));
  return std::span<const int>(found_).first(n);
}

}  // namespace sightline
