/// A symmetric positive definite matrix of any size, and its solver.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace sightline {

/// n x n, row by row; only the lower triangle is used. It allocates: for set-up only.
class Symmetric {
 public:
  explicit Symmetric(std::size_t n) : n_(n), a_(n * n) {}

  std::size_t size() const { return n_; }
  double& at(std::size_t i, std::size_t j) { return a_[i * n_ + j]; }
  double at(std::size_t i, std::size_t j) const { return a_[i * n_ + j]; }

  /// Cholesky factor L of A = L L^T, in place. A direction without information gets a pivot near
  /// infinity, which holds its solution at 0.
  void factor() {
    for (std::size_t j = 0; j < n_; ++j) {
      double pivot = at(j, j);
      const double whole = pivot;
      for (std::size_t k = 0; k < j; ++k) pivot -= at(j, k) * at(j, k);
      if (!(pivot > 1e-13 * whole)) pivot = std::numeric_limits<double>::max();
      at(j, j) = std::sqrt(pivot);
      for (std::size_t i = j + 1; i < n_; ++i) {
        double sum = at(i, j);
        for (std::size_t k = 0; k < j; ++k) sum -= at(i, k) * at(j, k);
        at(i, j) = sum / at(j, j);
      }
    }
  }
  /// y of A y = b, (n). Call factor() first.
  std::vector<double> solve(std::vector<double> b) const {
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t k = 0; k < i; ++k) b[i] -= at(i, k) * b[k];
      b[i] /= at(i, i);
    }
    for (std::size_t i = n_; i-- > 0;) {
      for (std::size_t k = i + 1; k < n_; ++k) b[i] -= at(k, i) * b[k];
      b[i] /= at(i, i);
    }
    return b;
  }

 private:
  std::size_t n_;
  std::vector<double> a_;
};

}  // namespace sightline
