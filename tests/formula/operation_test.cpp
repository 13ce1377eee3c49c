#include "sightline/formula/operation.hpp"

#include <gtest/gtest.h>

#include <array>
#include <utility>

#include "sightline/base.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// Calls f.template operator()<code>() for every code.
template <class F>
void for_each_code(F&& f) {
  [&]<std::size_t... i>(std::index_sequence<i...>) { (f.template operator()<static_cast<Code>(i)>(), ...); }
  (std::make_index_sequence<codes>());
}

TEST(Operation, OnALaneIsThatOfADoubleInEach) {
  Random random(1);
  for_each_code([&]<Code code>() {
    for (int k = 0; k < 200; ++k) {
      const auto a = uniform_array<4>(random, -3, 3), b = uniform_array<4>(random, -3, 3),
                 c = uniform_array<4>(random, -3, 3);
      using L = Lane<4>;
      const L result = operation<code>(L::load(a.data()), L::load(b.data()), L::load(c.data()));
      for (int i = 0; i < 4; ++i) {
        const auto j = static_cast<std::size_t>(i);
        ASSERT_TRUE(same_bits(result[i], operation<code>(a[j], b[j], c[j]))) << static_cast<int>(code);
      }
    }
  });
}

TEST(Operation, NoOperandBeyondItsCountIsUsedAndEachWithinItIs) {
  Random random(2);
  for_each_code([&]<Code code>() {
    std::array<bool, 3> used{};
    for (int k = 0; k < 200; ++k) {
      const auto x = uniform_array<3>(random, 0.1, 3);
      for (std::size_t i = 0; i < 3; ++i) {
        auto y = x;
        y[i] = uniform(random, 0.1, 3);
        used[i] = used[i] || !same_bits(operation<code>(x[0], x[1], x[2]), operation<code>(y[0], y[1], y[2]));
      }
    }
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(used[static_cast<std::size_t>(i)], i < operand_count(code))
          << static_cast<int>(code) << " " << i;
    }
  });
}

TEST(Operation, ProductsInSumsAreRoundedOnce) {
  const double e = 0x1p-30, one = 1 + e;  // one^2 = 1 + 2 e + e^2, whose last term a rounded product loses
  EXPECT_EQ(operation<Code::multiply_add>(one, one, -(1 + 2 * e)), e * e);
  EXPECT_EQ(operation<Code::multiply_subtract>(one, one, 1 + 2 * e), e * e);
  EXPECT_EQ(operation<Code::subtract_product>(one, one, 1 + 2 * e), -e * e);
}

}  // namespace
}  // namespace sightline
