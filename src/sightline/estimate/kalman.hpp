/// Kalman update with a chi-squared gate.
#pragma once

#include <array>
#include <limits>
#include <span>

#include "sightline/base.hpp"

namespace sightline {

/// A measurement of a filter's state: innovation y = measured - expected, H = d expected / d error
/// state, R = covariance of the measurement.
template <int m, int n>
struct Innovation {
  Column<m> y;
  Mat<m, n> H;
  Mat<m, m> R;
};

/// The first k components of a measurement.
template <int k, int m, int n>
Innovation<k, n> first(const Innovation<m, n>& of) noexcept {
  return {block<k, 1>(of.y, 0, 0), block<k, n>(of.H, 0, 0), block<k, k>(of.R, 0, 0)};
}

/// Gate for y^T S^-1 y of m components: the 99.9 % quantile of chi^2 with m degrees of freedom.
template <int m>
inline constexpr double chi_squared_gate = std::array{10.828, 13.816, 16.266, 18.467}[std::size_t{m - 1}];

/// The last component of a measurement.
template <int m, int n>
Innovation<1, n> last_one(const Innovation<m, n>& of) noexcept {
  return {block<1, 1>(of.y, m - 1, 0), block<1, n>(of.H, m - 1, 0), block<1, 1>(of.R, m - 1, m - 1)};
}

/// Result of an update.
struct Gated {
  bool accepted = false;
  double squared = 0.0;  ///< y^T S^-1 y; infinite where S is not positive definite
};

/// With S = H P H^T + R and K = P H^T S^-1, if y^T S^-1 y is within the gate: dx <- K y and, in
/// Joseph's form,
///
///   P <- (1 - K H) P (1 - K H)^T + K R K^T.
///
/// Otherwise P and dx are unchanged.
template <int m, int n>
Gated update(Mat<n, n>& P, const Innovation<m, n>& of, Column<n>& dx) noexcept {
  // Most columns of H are 0, so the sums run over the other columns only.
  std::array<int, static_cast<std::size_t>(n)> used;
  std::size_t count = 0;
  for (int l = 0; l < n; ++l)
    for (int a = 0; a < m; ++a) {
      if (of.H(a, l) == 0) continue;
      used[count++] = l;
      break;
    }
  const std::span<const int> columns(used.data(), count);
  // G^T = H P, S = H P H^T + R.
  Mat<m, n> Gt;
  for (int a = 0; a < m; ++a)
    for (const int l : columns)
      for (int j = 0; j < n; ++j) Gt(a, j) += of.H(a, l) * P(l, j);
  Mat<m, m> S = of.R;
  for (int a = 0; a < m; ++a)
    for (int b = 0; b < m; ++b)
      for (const int l : columns) S(a, b) += Gt(a, l) * of.H(b, l);
  const Cholesky<m> factor(S);
  if (!factor.positive) return {false, std::numeric_limits<double>::infinity()};
  const Column<m> white = factor.forward(of.y);
  Gated result;
  for (int a = 0; a < m; ++a) result.squared += white(a, 0) * white(a, 0);
  result.accepted = result.squared <= chi_squared_gate<m>;
  if (!result.accepted) return result;

  const Mat<m, n> Kt = factor.solve(Gt);
  for (int i = 0; i < n; ++i) {
    dx(i, 0) = 0.0;
    for (int a = 0; a < m; ++a) dx(i, 0) += Kt(a, i) * of.y(a, 0);
  }
  // A = (1 - K H) P, then A (1 - K H)^T + K R K^T = A - (A H^T - K R) K^T.
  const Mat<m, n> RKt = of.R * Kt;
  for (int i = 0; i < n; ++i) {
    for (int a = 0; a < m; ++a)
      for (int j = 0; j < n; ++j) P(i, j) -= Kt(a, i) * Gt(a, j);
    std::array<double, static_cast<std::size_t>(m)> c;
    for (int a = 0; a < m; ++a) {
      double sum = 0.0;
      for (const int l : columns) sum += P(i, l) * of.H(a, l);
      c[static_cast<std::size_t>(a)] = sum - RKt(a, i);
    }
    for (int a = 0; a < m; ++a)
      for (int j = 0; j < n; ++j) P(i, j) -= c[static_cast<std::size_t>(a)] * Kt(a, j);
  }
  make_symmetric(P);
  return result;
}

}  // namespace sightline
