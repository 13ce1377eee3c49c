/// Riccati stage as dense loops over any scalar. With numbers it is the textbook recursion; with
/// the recording scalar zeros and constants fold to the sparse code of one model;
/// docs/equations.md, 11.
#pragma once

#include <cstddef>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

/// Dense matrix, initially zero, row-major.
template <class S>
class Matrix {
 public:
  Matrix(int rows, int columns)
      : columns_(columns), entries_(static_cast<std::size_t>(rows * columns), S(0.0)) {}
  S& operator()(int i, int j) { return entries_[static_cast<std::size_t>(i * columns_ + j)]; }
  const S& operator()(int i, int j) const { return entries_[static_cast<std::size_t>(i * columns_ + j)]; }

 private:
  int columns_;
  std::vector<S> entries_;
};

/// Linear-quadratic stage and the results of its elimination.
template <class S>
struct RiccatiStage {
  int nx, nu;
  Matrix<S> A{nx, nx}, B{nx, nu};                     // y_next = A y + B du
  Matrix<S> Q{nx, nx}, G{nu, nx}, R{nu, nu};          // Phi_xx, Phi_ux, Phi_uu
  std::vector<S> r = std::vector<S>(at(nu), S(0.0));  // Phi_u
  Matrix<S> L{nu, nu}, K{nu, nx}, Y{nu, nx}, Z{nu, nx};
  std::vector<S> inverse_D = r, k = r, y = r, z = r;
  Matrix<S> PA{nx, nx};

  /// Eliminates du for the cost-to-go P and the costate increment e of the next stage: R + B'PB = L
  /// D L', K = L^-T D^-1 L^-1 (G + B'PA), k likewise; pivots are at least `floor`. An input with
  /// infinite R does not move: the inverse of its pivot and its row are zero.
  void eliminate(const Matrix<S>& P, const std::vector<S>& e, const std::vector<S>& floor, S& pivot_shift) {
    Matrix<S> PB(nx, nu);
    for (int i = 0; i < nx; ++i) {
      for (int j = 0; j < nx; ++j)
        for (int q = 0; q < nx; ++q) PA(i, j) += P(i, q) * A(q, j);
    }
    for (int i = 0; i < nx; ++i) {
      for (int b = 0; b < nu; ++b)
        for (int q = 0; q < nx; ++q) PB(i, b) += P(i, q) * B(q, b);
    }
    for (int a = 0; a < nu; ++a) {
      for (int b = 0; b <= a; ++b)
        for (int q = 0; q < nx; ++q) R(a, b) += B(q, a) * PB(q, b);
      for (int j = 0; j < nx; ++j)
        for (int q = 0; q < nx; ++q) G(a, j) += B(q, a) * PA(q, j);
      for (int q = 0; q < nx; ++q) r[at(a)] += B(q, a) * e[at(q)];
    }
    for (int a = 0; a < nu; ++a) {
      pivot_shift = maximum(floor[at(a)] - R(a, a), pivot_shift);
      inverse_D[at(a)] = 1.0 / maximum(R(a, a), floor[at(a)]);
      for (int b = a + 1; b < nu; ++b) L(b, a) = R(b, a) * inverse_D[at(a)];
      for (int b = a + 1; b < nu; ++b)
        for (int c = a + 1; c <= b; ++c) R(b, c) -= L(b, a) * R(c, a);
    }
    for (int j = 0; j < nx; ++j) {
      for (int a = 0; a < nu; ++a) {
        Y(a, j) = G(a, j);
        for (int b = 0; b < a; ++b) Y(a, j) -= L(a, b) * Y(b, j);
        Z(a, j) = Y(a, j) * inverse_D[at(a)];
      }
    }
    for (int a = 0; a < nu; ++a) {
      y[at(a)] = r[at(a)];
      for (int b = 0; b < a; ++b) y[at(a)] -= L(a, b) * y[at(b)];
      z[at(a)] = y[at(a)] * inverse_D[at(a)];
    }
    for (int a = nu - 1; a >= 0; --a) {
      for (int j = 0; j < nx; ++j) {
        K(a, j) = Z(a, j);
        for (int b = a + 1; b < nu; ++b) K(a, j) -= L(b, a) * K(b, j);
      }
      k[at(a)] = z[at(a)];
      for (int b = a + 1; b < nu; ++b) k[at(a)] -= L(b, a) * k[at(b)];
    }
  }

  /// Entry (i, j) of this stage's cost-to-go.
  S cost_to_go(int i, int j) const {
    S s = Q(i, j);
    for (int q = 0; q < nx; ++q) s += A(q, i) * PA(q, j);
    for (int a = 0; a < nu; ++a) s -= Y(a, i) * Z(a, j);
    return s;
  }
  /// Entry j of this stage's costate increment.
  S costate_increment(int j, const std::vector<S>& e) const {
    S s = 0.0;
    for (int q = 0; q < nx; ++q) s += A(q, j) * e[at(q)];
    for (int a = 0; a < nu; ++a) s -= Z(a, j) * y[at(a)];
    return s;
  }
};

}  // namespace sightline
