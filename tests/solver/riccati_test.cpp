#include "sightline/solver/kernels/riccati.hpp"

#include <gtest/gtest.h>

#include <limits>

// GCC 12 mistakes the masks of its own intrinsics for a fault.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <Eigen/Dense>

#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

Eigen::MatrixXd random_matrix(Random& random, int rows, int columns) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(random, -1, 1); });
}

Eigen::MatrixXd random_positive(Random& random, int n) {
  const Eigen::MatrixXd M = random_matrix(random, n, n);
  return M * M.transpose() + Eigen::MatrixXd::Identity(n, n);
}

Matrix<double> copy(const Eigen::MatrixXd& from) {
  Matrix<double> to(static_cast<int>(from.rows()), static_cast<int>(from.cols()));
  for (int i = 0; i < from.rows(); ++i)
    for (int j = 0; j < from.cols(); ++j) to(i, j) = from(i, j);
  return to;
}

std::vector<double> copy_vector(const Eigen::VectorXd& v) { return {v.begin(), v.end()}; }

TEST(RiccatiStage, OnNumbersItIsTheSolutionOfTheLinearQuadraticStage) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const int nx = 1 + static_cast<int>(random() % 9), nu = 1 + static_cast<int>(random() % 4);
    const Eigen::MatrixXd A = random_matrix(random, nx, nx), B = random_matrix(random, nx, nu),
                          Q = random_positive(random, nx), R = random_positive(random, nu),
                          G = 0.1 * random_matrix(random, nu, nx), P = random_positive(random, nx);
    const Eigen::VectorXd r = random_matrix(random, nu, 1), e = random_matrix(random, nx, 1);
    RiccatiStage<double> stage{.nx = nx, .nu = nu};
    stage.A = copy(A), stage.B = copy(B), stage.Q = copy(Q), stage.R = copy(R), stage.G = copy(G);
    stage.r = copy_vector(r);
    double pivot_shift = 0.0;
    stage.eliminate(copy(P), copy_vector(e), std::vector<double>(static_cast<std::size_t>(nu), 1e-6),
                    pivot_shift);
    EXPECT_EQ(pivot_shift, 0.0);

    const Eigen::MatrixXd M_uu = R + B.transpose() * P * B, M_ux = G + B.transpose() * P * A;
    const Eigen::VectorXd M_u = r + B.transpose() * e;
    const Eigen::MatrixXd K = M_uu.ldlt().solve(M_ux);
    const Eigen::VectorXd k = M_uu.ldlt().solve(M_u), e_0 = A.transpose() * e - M_ux.transpose() * k;
    const Eigen::MatrixXd P_0 = Q + A.transpose() * P * A - M_ux.transpose() * K;
    for (int a = 0; a < nu; ++a) {
      EXPECT_LE(relative_error(stage.k[static_cast<std::size_t>(a)], k(a)), 1e-11);
      for (int j = 0; j < nx; ++j) EXPECT_LE(relative_error(stage.K(a, j), K(a, j)), 1e-11);
    }
    for (int i = 0; i < nx; ++i) {
      EXPECT_LE(relative_error(stage.costate_increment(i, copy_vector(e)), e_0(i)), 1e-11);
      for (int j = i; j < nx; ++j) EXPECT_LE(relative_error(stage.cost_to_go(i, j), P_0(i, j)), 1e-11);
    }
  }
}

TEST(RiccatiStage, AnInputOfInfiniteWeightDoesNotMove) {
  Random random(2);
  for (int trial = 0; trial < 100; ++trial) {
    RiccatiStage<double> stage{.nx = 4, .nu = 3};
    stage.A = copy(random_matrix(random, 4, 4)), stage.B = copy(random_matrix(random, 4, 3));
    stage.R = copy(random_positive(random, 3));
    stage.r = {1, 1, 1};
    const int held = static_cast<int>(random() % 3);
    stage.R(held, held) = std::numeric_limits<double>::infinity();
    double pivot_shift = 0.0;
    stage.eliminate(copy(random_positive(random, 4)), {1, 1, 1, 1}, {1e-6, 1e-6, 1e-6}, pivot_shift);
    EXPECT_EQ(stage.k[static_cast<std::size_t>(held)], 0.0);
    for (int j = 0; j < 4; ++j) EXPECT_EQ(stage.K(held, j), 0.0);
  }
}

TEST(RiccatiStage, APivotBelowItsFloorIsDoubtedByWhatItLacks) {
  RiccatiStage<double> stage{.nx = 1, .nu = 1};
  stage.R(0, 0) = -2.0;
  stage.r = {1.0};
  double pivot_shift = 0.0;
  stage.eliminate(Matrix<double>(1, 1), {0.0}, {0.5}, pivot_shift);
  EXPECT_EQ(pivot_shift, 2.5);
  EXPECT_EQ(stage.k[0], 2.0);
}

}  // namespace
}  // namespace sightline
