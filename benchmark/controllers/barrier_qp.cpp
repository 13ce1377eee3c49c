#include "benchmark/controllers/barrier_qp.hpp"

#include <bit>
#include <cstddef>

#include "sightline/base.hpp"

namespace sightline::benchmark {
namespace {

double product(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

}  // namespace

std::array<double, 4> nearest_within(const std::array<double, 4>& v_0, const std::array<double, 4>& W,
                                     std::span<const BarrierRow> rows, double rho) noexcept {
  const std::size_t n = rows.size();
  std::array<double, 4> least = v_0;
  double least_excess = infinity;
  for (unsigned set = 0; set < (1U << n); ++set) {
    // Rows outside the set have the equation lambda = 0.
    Mat<4, 4> M = identity<4>();
    Column<4> right{};
    for (int i = 0; i < static_cast<int>(n); ++i) {
      if (((set >> i) & 1U) == 0) continue;
      const BarrierRow& row = rows[at(i)];
      right(i, 0) = row.b - product(row.a, v_0);
      for (int j = 0; j < static_cast<int>(n); ++j) {
        if (((set >> j) & 1U) == 0) continue;
        double sum = i == j ? 1 / rho : 0.0;
        for (std::size_t k = 0; k < 4; ++k) sum += row.a[k] * rows[at(j)].a[k] / W[k];
        M(i, j) = sum;
      }
    }
    const Cholesky<4> factor(M);
    if (!factor.positive) continue;
    const Column<4> lambda = factor.solve(right);
    std::array<double, 4> v = v_0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < 4; ++k) v[k] += lambda(static_cast<int>(i), 0) * rows[i].a[k] / W[k];
    // The set of the solution has no excess but rounding.
    double excess = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double multiplier = lambda(static_cast<int>(i), 0);
      const bool active = ((set >> i) & 1U) != 0;
      excess = std::max(excess, active ? -multiplier : rows[i].b - product(rows[i].a, v));
    }
    if (excess < least_excess) least_excess = excess, least = v;
    if (least_excess <= 0) break;
  }
  return least;
}

}  // namespace sightline::benchmark
