#include "sightline/base/quantile.hpp"

#include <gtest/gtest.h>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(Quantile, IsTheLeastThatItsShareDoesNotExceed) {
  Random random(1);
  for (int n = 1; n < 40; ++n) {
    std::vector<double> values;
    for (int i = 0; i < n; ++i) values.push_back(uniform(random, -1, 1));
    for (const double q : {0.0, 0.01, 0.3, 0.5, 0.99, 1.0}) {
      const double found = quantile(values, q);
      const auto up_to = std::count_if(values.begin(), values.end(), [&](double v) { return v <= found; });
      const auto below = std::count_if(values.begin(), values.end(), [&](double v) { return v < found; });
      EXPECT_GE(static_cast<double>(up_to), q * n);
      EXPECT_TRUE(below == 0 || static_cast<double>(below) < q * n);
    }
  }
}

TEST(Quantile, OfNothingIsNoNumber) { EXPECT_TRUE(std::isnan(quantile({}, 0.5))); }

}  // namespace
}  // namespace sightline
