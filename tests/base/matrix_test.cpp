#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "sightline/base.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

template <int r, int c>
Mat<r, c> random_matrix(Random& random) {
  Mat<r, c> a;
  for (int i = 0; i < r; ++i)
    for (int j = 0; j < c; ++j) a(i, j) = uniform(random, -2, 2);
  return a;
}
template <int r, int c>
Eigen::Matrix<double, r, c> eigen(const Mat<r, c>& a) {
  Eigen::Matrix<double, r, c> b;
  for (int i = 0; i < r; ++i)
    for (int j = 0; j < c; ++j) b(i, j) = a(i, j);
  return b;
}

TEST(Matrix, ProductsSumsAndTransposesAreThoseOfEigen) {
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const auto a = random_matrix<4, 7>(random);
    const auto b = random_matrix<7, 3>(random), c = random_matrix<7, 3>(random);
    EXPECT_LE((eigen(a * (b + 2.0 * c - c)) - eigen(a) * (eigen(b) + eigen(c))).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_EQ(transposed(transposed(a)), a);
    EXPECT_LE((eigen(transposed(a * b)) - eigen(transposed(b) * transposed(a))).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(Matrix, BlocksAreReadWhereTheyWereSet) {
  Random random(2);
  auto a = random_matrix<6, 6>(random);
  const auto b = random_matrix<2, 3>(random);
  set_both(a, 1, 3, b);
  EXPECT_EQ((block<2, 3>(a, 1, 3)), b);
  EXPECT_EQ((block<3, 2>(a, 3, 1)), transposed(b));
  make_symmetric(a);
  EXPECT_EQ(transposed(a), a);
  EXPECT_EQ(trace(identity<5>(0.5)), 2.5);
}

TEST(Matrix, VectorsOfSpaceAreColumns) {
  Random random(3);
  const auto A = random_matrix<3, 3>(random);
  const Vec3<double> a = random_point(random, 2), b = random_point(random, 2);
  const Vec3<double> product = A * a;
  EXPECT_EQ(column(product), A * column(a));
  EXPECT_EQ(outer(a, b), column(a) * transposed(column(b)));
  EXPECT_EQ(column(vec3(column(a))), column(a));
}

TEST(Matrix, CholeskySolvesAndRefusesWhatIsNotPositive) {
  Random random(4);
  for (int k = 0; k < 100; ++k) {
    const auto B = random_matrix<5, 5>(random);
    const auto A = B * transposed(B) + identity<5>(0.1);
    const auto y = random_matrix<5, 2>(random);
    const Cholesky<5> factor(A);
    ASSERT_TRUE(factor.positive);
    EXPECT_LE((eigen(A * factor.solve(y)) - eigen(y)).cwiseAbs().maxCoeff(), 1e-11);
    const auto e = random_matrix<5, 1>(random);
    EXPECT_NEAR(mahalanobis(e, A), (eigen(e).transpose() * eigen(A).ldlt().solve(eigen(e)))(0), 1e-9);
  }
  for (const double bad :
       {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    auto A = identity<3>();
    A(1, 1) = bad;
    EXPECT_FALSE(Cholesky<3>(A).positive) << bad;
    EXPECT_EQ(mahalanobis(Column<3>{}, A), std::numeric_limits<double>::infinity());
  }
}

}  // namespace
}  // namespace sightline
