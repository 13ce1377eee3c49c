#include "sightline/base/symmetric.hpp"

#include <gtest/gtest.h>

#include <random>

namespace sightline {
namespace {

Symmetric random_symmetric(std::size_t n, std::mt19937_64& random) {
  std::normal_distribution<double> draw;
  std::vector<double> M(n * n);
  for (double& m : M) m = draw(random);
  Symmetric A(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < n; ++k) A.at(i, j) += M[i * n + k] * M[j * n + k];
  for (std::size_t i = 0; i < n; ++i) A.at(i, i) += 0.1;
  return A;
}

TEST(Symmetric, SolvesWhatItMultiplies) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> draw;
  for (std::size_t n = 1; n <= 12; ++n) {
    const Symmetric A = random_symmetric(n, random);
    std::vector<double> y(n), b(n);
    for (double& v : y) v = draw(random);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) b[i] += A.at(i, j) * y[j];
    Symmetric factored = A;
    factored.factor();
    const std::vector<double> found = factored.solve(b);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(found[i], y[i], 1e-9) << n;
  }
}

TEST(Symmetric, HoldsADirectionOfWhichNothingWasSeen) {
  Symmetric A(3);
  A.at(0, 0) = 4, A.at(1, 1) = 0, A.at(2, 2) = 9;
  A.factor();
  const std::vector<double> y = A.solve({4.0, 1.0, 9.0});
  EXPECT_NEAR(y[0], 1.0, 1e-12);
  EXPECT_NEAR(y[1], 0.0, 1e-12);
  EXPECT_NEAR(y[2], 1.0, 1e-12);
}

}  // namespace
}  // namespace sightline
