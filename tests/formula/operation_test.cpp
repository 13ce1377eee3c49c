#include "sightline/formula/operation.hpp"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Operation, ProductsInSumsAreRoundedOnce) {
  const double e = 0x1p-30, one = 1 + e;  // one^2 = 1 + 2 e + e^2; rounding loses the last term
  EXPECT_EQ(operation<Code::multiply_add>(one, one, -(1 + 2 * e)), e * e);
  EXPECT_EQ(operation<Code::multiply_subtract>(one, one, 1 + 2 * e), e * e);
  EXPECT_EQ(operation<Code::subtract_product>(one, one, 1 + 2 * e), -e * e);
}

}  // namespace
}  // namespace sightline
