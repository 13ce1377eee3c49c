/// The quadratic program of a safety filter: the command nearest to the wanted one that keeps up to four barriers.
#pragma once

#include <array>
#include <span>

namespace sightline::benchmark {

/// a' v >= b.
struct BarrierRow {
  std::array<double, 4> a{};
  double b = 0.0;
};

inline constexpr int rows_max = 4;

/// Minimises
///
///   1/2 (v - v_0)' W (v - v_0) + rho/2 sum_i s_i^2   subject to   a_i' v + s_i >= b_i
///
/// by enumeration of the active sets: the multipliers of set A solve (a W^-1 a' + 1/rho) lambda = b - a v_0, and the
/// one set with lambda >= 0 and all other rows satisfied is the solution. It exists for all rows, since rho is finite.
/// @param W     weights, > 0
/// @param rows  at most rows_max
std::array<double, 4> nearest_within(const std::array<double, 4>& v_0, const std::array<double, 4>& W,
                                     std::span<const BarrierRow> rows, double rho) noexcept;

}  // namespace sightline::benchmark
