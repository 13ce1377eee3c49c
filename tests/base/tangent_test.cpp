#include <gtest/gtest.h>

#include <array>

#include "sightline/base.hpp"
#include "tests/support/difference.hpp"
#include "tests/support/error.hpp"
#include "tests/support/formula.hpp"
#include "tests/support/strict.hpp"

namespace sightline {
namespace {

constexpr std::size_t n = 3;

TEST(Tangent, TheRateIsTheDerivativeAlongTheMotion) {
  Random random(1);
  for (int k = 0; k < 2000; ++k) {
    const auto x = uniform_array<n>(random, -1.5, 1.5), direction = uniform_array<n>(random, -1, 1);
    const Formula formula(random, x, 1 + static_cast<int>(random() % 16));
    std::vector<Tangent<double>> moving;
    for (std::size_t i = 0; i < n; ++i) moving.emplace_back(x[i], direction[i]);

    const auto along = [&](const std::vector<Wide>& s) {
      std::vector<Wide> point;
      for (std::size_t i = 0; i < n; ++i) point.push_back(Wide(x[i]) + s[0] * Wide(direction[i]));
      return formula(point);
    };
    const std::array<double, 1> here = {0.0};
    EXPECT_LE(relative_error(formula(moving).rate, CentralDifference(along, here).first(0)), 1e-9) << k;
  }
}

TEST(Tangent, TheValueIsThatOfTheFormulaBitForBitAndAConstantStandsStill) {
  Random random(2);
  for (int k = 0; k < 2000; ++k) {
    const auto x = uniform_array<n>(random, -1.5, 1.5);
    const Formula formula(random, x, 12);
    const Tangent<double> constant = formula(std::vector<Tangent<double>>(x.begin(), x.end()));
    EXPECT_TRUE(same_bits(constant.value, formula(std::vector<double>(x.begin(), x.end()))));
    EXPECT_EQ(constant.rate, 0.0);
  }
}

TEST(Tangent, ItWorksOverAnyScalar) {
  Random random(4);
  for (int k = 0; k < 500; ++k) {
    const auto x = uniform_array<n>(random, -1.5, 1.5), direction = uniform_array<n>(random, -1, 1);
    const Formula formula(random, x, 12);
    std::vector<Tangent<double>> plain;
    std::vector<Tangent<Strict>> strict;
    for (std::size_t i = 0; i < n; ++i) {
      plain.emplace_back(x[i], direction[i]);
      strict.emplace_back(Strict(x[i]), Strict(direction[i]));
    }
    EXPECT_TRUE(same_bits(formula(strict).rate.value(), formula(plain).rate));
  }
}

}  // namespace
}  // namespace sightline
