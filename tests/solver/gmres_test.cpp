#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sightline/solvers.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Random& random, int n) {
  return MatrixXd::NullaryExpr(n, n, [&] { return uniform(random, -1, 1); });
}

VectorXd random_vector(Random& random, int n) {
  return VectorXd::NullaryExpr(n, [&] { return uniform(random, -1, 1); });
}

struct Solved {
  Gmres::Outcome outcome;
  VectorXd x;
  int products = 0;
  bool padding_is_zero = true;
};

/// Solves A x = b in padded memory, in as many iterations as there is time for.
Solved solve(const MatrixXd& A, const VectorXd& b, int k_max, double tolerance, const VectorXd& x0,
             int in_time = 1000) {
  const int n = static_cast<int>(b.size());
  Gmres gmres(n, k_max);
  Rows rows(2, gmres.length());
  std::copy_n(b.data(), n, rows[0]);
  std::copy_n(x0.data(), n, rows[1]);
  Solved solved;
  solved.outcome = gmres.solve(
      [&](const double* v, double* out) {
        Eigen::Map<VectorXd>(out, n) = A * Eigen::Map<const VectorXd>(v, n);
        ++solved.products;
      },
      rows[0], rows[1], tolerance, [&] { return --in_time <= 0; });
  solved.x = Eigen::Map<const VectorXd>(rows[1], n);
  for (int i = n; i < gmres.length(); ++i) solved.padding_is_zero &= rows[1][i] == 0.0;
  return solved;
}

Solved solve(const MatrixXd& A, const VectorXd& b, int k_max, double tolerance) {
  return solve(A, b, k_max, tolerance, VectorXd::Zero(b.size()));
}

TEST(Dot, AddsInOneOrderWhateverTheWidthOfTheMachine) {
  Random random(1);
  for (const int n : {32, 64, 480, 960}) {
    Rows rows(2, n);
    for (double& v : rows.all()) v = uniform(random, -1, 1) * std::pow(10.0, uniform(random, -8, 8));
    std::array<double, dot_quantum> sum{};
    for (int i = 0; i < n; ++i) {
      double& s = sum[static_cast<std::size_t>(i % dot_quantum)];
      s = std::fma(rows[0][i], rows[1][i], s);
    }
    for (std::size_t half = dot_quantum / 2; half > 0; half /= 2) {
      for (std::size_t i = 0; i < half; ++i) sum[i] += sum[i + half];
    }
    EXPECT_TRUE(same_bits(dot(rows[0], rows[1], n), sum[0])) << n;
  }
}

TEST(Gmres, SolvesWellConditionedSystemsSymmetricOrNot) {
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 1 + static_cast<int>(random() % 70);
    MatrixXd A = random_matrix(random, n);
    if (trial % 2 == 0) A = MatrixXd(A + A.transpose());
    A = MatrixXd::Identity(n, n) * (trial % 3 == 0 ? -1.0 : 1.0) + A * (0.4 / std::sqrt(n));
    const VectorXd x = random_vector(random, n);
    const Solved run = solve(A, A * x, n + 1, 1e-12, random_vector(random, n));
    EXPECT_LE((run.x - x).norm(), 1e-10 * (1 + x.norm())) << n;
    EXPECT_TRUE(run.padding_is_zero);
  }
}

TEST(Gmres, TheResidualItReportsIsTheTrueOne) {
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + static_cast<int>(random() % 60), k_max = 1 + static_cast<int>(random() % 20);
    const MatrixXd A = random_matrix(random, n);
    const VectorXd b = random_vector(random, n);
    const Solved run = solve(A, b, k_max, 1e-10, random_vector(random, n));
    EXPECT_NEAR((b - A * run.x).norm(), run.outcome.residual, 1e-8);
  }
}

TEST(Gmres, EachIterationLowersTheResidualOrLeavesIt) {
  Random random(4);
  const int n = 40;
  const MatrixXd A = random_matrix(random, n);
  const VectorXd b = random_vector(random, n);
  double last = b.norm();
  for (int k = 1; k <= n; ++k) {
    const double residual = (b - A * solve(A, b, k, 0.0).x).norm();
    EXPECT_LE(residual, last + 1e-12);
    last = residual;
  }
  EXPECT_LE(last, 1e-9);
}

TEST(Gmres, StopsAtItsToleranceAndNotBefore) {
  Random random(5);
  for (const double tolerance : {1e-2, 1e-5, 1e-8}) {
    const int n = 60;
    const MatrixXd A = MatrixXd::Identity(n, n) + random_matrix(random, n) * 0.05;
    const VectorXd b = random_vector(random, n);
    const Solved run = solve(A, b, n, tolerance);
    ASSERT_LT(run.outcome.iterations, n);
    EXPECT_LE((b - A * run.x).norm(), 1.001 * tolerance);
    EXPECT_GT((b - A * solve(A, b, run.outcome.iterations - 1, tolerance).x).norm(), tolerance);
  }
}

TEST(Gmres, TakesNoMoreIterationsThanAllowedAndOneProductForEach) {
  Random random(6);
  for (int k_max = 1; k_max <= 30; ++k_max) {
    const Solved run = solve(random_matrix(random, 64), random_vector(random, 64), k_max, 0.0);
    EXPECT_EQ(run.outcome.iterations, k_max);
    EXPECT_EQ(run.products, k_max + 1);
  }
}

TEST(Gmres, WhereTimeEndsItReturnsWhatItsIterationsCameTo) {
  Random random(8);
  const MatrixXd A = random_matrix(random, 40);
  const VectorXd b = random_vector(random, 40);
  for (const int in_time : {0, 1, 7}) {
    const int iterations = std::max(in_time, 1);
    const Solved late = solve(A, b, 30, 0.0, VectorXd::Zero(40), in_time),
                 short_one = solve(A, b, iterations, 0.0);
    EXPECT_EQ(late.outcome.iterations, iterations);
    for (int i = 0; i < 40; ++i) EXPECT_TRUE(same_bits(late.x[i], short_one.x[i])) << i;
  }
}

TEST(Gmres, ReturnsAtAZeroResidualWithoutDividing) {
  Random random(7);
  const MatrixXd A = MatrixXd::Identity(20, 20) * 0.5;
  const VectorXd x = random_vector(random, 20);
  for (const double tolerance : {0.0, 1e-8}) {
    for (const VectorXd& start : {x, VectorXd(VectorXd::Zero(20))}) {
      const Solved run = solve(A, A * start, 10, tolerance, start);
      EXPECT_EQ(run.outcome.iterations, 0);
      EXPECT_EQ(run.outcome.residual, 0.0);
      EXPECT_EQ(run.x, start);
    }
  }
}

TEST(Gmres, AHappyBreakdownIsExact) {
  Random random(8);
  for (const int n : {5, 31, 64, 100}) {
    const VectorXd u = random_vector(random, n), v = random_vector(random, n) / n,
                   b = random_vector(random, n);
    const Solved identity = solve(MatrixXd::Identity(n, n), b, 10, 0.0);
    EXPECT_LE((identity.x - b).norm(), 1e-14 * b.norm());
    // The Krylov space of identity plus rank one has two dimensions.
    const MatrixXd A = MatrixXd::Identity(n, n) + u * v.transpose();
    const Solved rank_one = solve(A, b, 30, 1e-12);
    EXPECT_LE(rank_one.outcome.iterations, 2);
    EXPECT_LE((A * rank_one.x - b).norm(), 1e-12);
  }
}

TEST(Gmres, GoesOnPastABreakdownThatRoundingHidesWithoutSpoilingTheSolution) {
  Random random(9);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + static_cast<int>(random() % 10);
    const MatrixXd A = MatrixXd::Identity(n, n) + random_matrix(random, n) * (0.5 / n);
    const VectorXd b = random_vector(random, n);
    const Solved run = solve(A, b, 30, 0.0);
    EXPECT_LE((A * run.x - b).norm(), 1e-12) << n;
  }
}

TEST(Gmres, ASingularMatrixGivesFiniteNumbersAndNoLargerResidual) {
  Random random(10);
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + static_cast<int>(random() % 40),
              rank = static_cast<int>(random() % static_cast<unsigned>(n));
    MatrixXd A = random_matrix(random, n);
    if (trial % 2 == 0) {
      A.bottomRows(n - rank).setZero();
    } else {
      A = random_matrix(random, n).leftCols(rank) * random_matrix(random, n).topRows(rank);
    }
    const VectorXd b = random_vector(random, n);
    const Solved run = solve(A, b, 30, 1e-10);
    EXPECT_TRUE(run.x.allFinite()) << n << ", rank " << rank;
    EXPECT_LE((b - A * run.x).norm(), (1 + 1e-9) * b.norm()) << n << ", rank " << rank;
  }
  const Solved zero = solve(MatrixXd::Zero(8, 8), random_vector(random, 8), 30, 1e-10);
  EXPECT_EQ(zero.x, VectorXd::Zero(8));
}

TEST(Gmres, AProductThatIsNotFiniteLeavesAFiniteSolution) {
  Random random(11);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int at = 1; at < 10; ++at) {
      const int n = 40;
      const MatrixXd A = random_matrix(random, n);
      Gmres gmres(n, 20);
      Rows rows(2, gmres.length());
      for (int i = 0; i < n; ++i) rows[0][i] = uniform(random, -1, 1);
      int products = 0;
      gmres.solve(
          [&](const double* v, double* out) {
            Eigen::Map<VectorXd>(out, n) = A * Eigen::Map<const VectorXd>(v, n);
            if (++products > at) out[7] = bad;
          },
          rows[0], rows[1], 0.0);
      EXPECT_TRUE((Eigen::Map<VectorXd>(rows[1], n).allFinite())) << bad << " at product " << at;
    }
  }
}

TEST(Gmres, ARightSideThatIsNotFiniteOrTooLargeIsLeftAlone) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e305}) {
    const Solved run =
        solve(MatrixXd::Identity(6, 6), VectorXd::Constant(6, bad), 10, 1e-8, VectorXd::Ones(6));
    EXPECT_EQ(run.outcome.iterations, 0);
    EXPECT_EQ(run.x, VectorXd::Ones(6));
  }
}

TEST(Gmres, TheSameSystemGivesTheSameBitsAndLeavesNothingBehind) {
  Random random(12);
  const int n = 50;
  const MatrixXd A = random_matrix(random, n);
  const VectorXd b = random_vector(random, n), other = random_vector(random, n);
  Gmres used(n, 15);
  const auto product = [&](const double* v, double* out) {
    Eigen::Map<VectorXd>(out, n) = A * Eigen::Map<const VectorXd>(v, n);
  };
  Rows rows(4, used.length());
  std::copy_n(other.data(), n, rows[0]);
  std::copy_n(b.data(), n, rows[2]);
  used.solve(product, rows[0], rows[1], 0.0);
  used.solve(product, rows[2], rows[3], 0.0);
  const Solved fresh = solve(A, b, 15, 0.0);
  for (int i = 0; i < n; ++i) EXPECT_TRUE(same_bits(rows[3][i], fresh.x[i]));
}

}  // namespace
}  // namespace sightline
