/// GMRES (Saad and Schultz 1986) for a small real-time budget: preallocated memory, no restart,
/// guarded termination.
#pragma once

#include <span>
#include <vector>

#include "sightline/formula/interpret.hpp"

namespace sightline {

/// Numbers that are summed in parallel in a fixed order, independent of the machine's lane width.
inline constexpr int dot_quantum = 32;

/// sum a_i b_i over n numbers, n a multiple of `dot_quantum`.
double dot(const double* a, const double* b, int n) noexcept;

class Gmres {
 public:
  /// @param n  unknowns; vectors passed to `solve` have `length()` >= n numbers, zero beyond n
  Gmres(int n, int k_max);

  int length() const { return length_; }

  struct Outcome {
    int iterations = 0;
    double residual = 0.0;  ///< ||b - A x||, from the rotations
  };

  /// Improves x towards A x = b, starting from the given x.
  /// @param product    called as product(v, out): out = A v; both of length(), out zero beyond n
  /// @param tolerance  stops when ||b - A x|| <= tolerance
  /// @param late       called as late() after each iteration; true ends the iterations
  template <class Product, class Late>
  Outcome solve(Product&& product, const double* b, double* x, double tolerance, Late&& late) noexcept;
  template <class Product>
  Outcome solve(Product&& product, const double* b, double* x, double tolerance) noexcept {
    return solve(product, b, x, tolerance, [] { return false; });
  }

 private:
  double& hessenberg(int i, int j) {
    return h_[static_cast<std::size_t>(j) * static_cast<std::size_t>(k_max_ + 1) +
              static_cast<std::size_t>(i)];
  }
  /// Orthogonalises v_{k+1} against the basis and normalises it. @return its length before
  /// normalisation
  double orthogonalise(int k) noexcept;
  /// Applies the rotations to column k and adds one that eliminates its last entry. @return false
  /// if singular
  bool rotate(int k) noexcept;
  /// x += V y, y from the triangular system of k columns.
  void advance(int k, double* x) noexcept;

  int length_, k_max_;
  Rows basis_;
  std::vector<double> h_, cos_, sin_, g_, y_;
};

template <class Product, class Late>
Gmres::Outcome Gmres::solve(Product&& product, const double* b, double* x, double tolerance,
                            Late&& late) noexcept {
  double* const v0 = basis_[0];
  product(static_cast<const double*>(x), v0);
  for (int i = 0; i < length_; ++i) v0[i] = b[i] - v0[i];
  const double beta = sqrt(dot(v0, v0, length_));
  // A zero residual leaves nothing to divide by; a non-finite one cannot be reduced.
  if (!(beta > tolerance) || !(beta < 1e300)) return {0, beta};
  for (int i = 0; i < length_; ++i) v0[i] /= beta;
  g_[0] = beta;
  double residual = beta;
  int k = 0;
  while (k < k_max_ && residual > tolerance) {
    product(static_cast<const double*>(basis_[k]), basis_[k + 1]);
    const double length = orthogonalise(k);
    if (!rotate(k)) break;
    residual = g_[static_cast<std::size_t>(k) + 1] < 0 ? -g_[static_cast<std::size_t>(k) + 1]
                                                       : g_[static_cast<std::size_t>(k) + 1];
    ++k;
    if (length == 0) break;  // happy breakdown: x is exact in the Krylov space
    if (late()) break;
  }
  advance(k, x);
  return {k, residual};
}

}  // namespace sightline
