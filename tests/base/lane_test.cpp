#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "sightline/base.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// Ordinary numbers, and those at which arithmetic is special.
double draw(Random& random) {
  using Limits = std::numeric_limits<double>;
  static constexpr std::array special = {0.0,
                                         -0.0,
                                         1.0,
                                         -1.0,
                                         Limits::min(),
                                         Limits::denorm_min(),
                                         Limits::max(),
                                         -Limits::max(),
                                         Limits::infinity(),
                                         -Limits::infinity(),
                                         Limits::quiet_NaN()};
  return random() % 4 == 0 ? special[random() % special.size()] : uniform(random, -3, 3);
}

template <class L>
class LaneLaws : public testing::Test {
 protected:
  static constexpr int width = static_cast<int>(sizeof(L) / sizeof(double));
  using Row = std::array<double, static_cast<std::size_t>(width)>;

  static Row row(Random& random) {
    Row r;
    for (double& v : r) v = draw(random);
    return r;
  }

  /// on_lanes(packs...) is on_double(numbers...) in every lane.
  template <class OnLanes, class OnDouble>
  static void expect_elementwise(OnLanes on_lanes, OnDouble on_double) {
    Random random(1);
    for (int k = 0; k < 5000; ++k) {
      const Row a = row(random), b = row(random), c = row(random);
      const L result = on_lanes(L::load(a.data()), L::load(b.data()), L::load(c.data()));
      for (int i = 0; i < width; ++i) {
        const auto j = static_cast<std::size_t>(i);
        ASSERT_TRUE(same_bits(result[i], on_double(a[j], b[j], c[j]))) << a[j] << ' ' << b[j] << ' ' << c[j];
      }
    }
  }
};

using Widths = testing::Types<Lane<1>, Lane<2>, Lane<4>, Lane<8>>;
TYPED_TEST_SUITE(LaneLaws, Widths);

TYPED_TEST(LaneLaws, FindsALaneBelowZero) {
  Random random(2);
  for (int k = 0; k < 5000; ++k) {
    const auto row = TestFixture::row(random);
    const bool any = std::any_of(row.begin(), row.end(), [](double v) { return v < 0; });
    ASSERT_EQ(any_negative(TypeParam::load(row.data())), any);
  }
}

TYPED_TEST(LaneLaws, EveryOperationIsThatOfADoubleInEachLane) {
  const auto law = [](auto f) { TestFixture::expect_elementwise(f, f); };
  law([](auto a, auto b, auto) { return a + b; });
  law([](auto a, auto b, auto) { return a - b; });
  law([](auto a, auto b, auto) { return a * b; });
  law([](auto a, auto b, auto) { return a / b; });
  law([](auto a, auto, auto) { return -a; });
  law([](auto a, auto b, auto c) { return fma(a, b, c); });
  law([](auto a, auto, auto) { return sqrt(a); });
  law([](auto a, auto b, auto c) { return where_negative(a, b, c); });
  law([](auto a, auto, auto) { return clamp(a, -0.5, 1.5); });
  law([](auto a, auto b, auto c) { return clamp(a, b, c); });
  law([](auto a, auto b, auto) { return maximum(a, b); });
  law([](auto a, auto b, auto) { return minimum(a, b); });
  law([](auto a, auto b, auto) { return detail::keep_nan(a, b); });
  law([](auto a, auto b, auto c) {
    a += b;
    a *= c;
    a -= b;
    return a;
  });
}

TYPED_TEST(LaneLaws, AConstantIsTheSameInAllLanesItsSignIncluded) {
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const double constant = draw(random);
    const TypeParam pack(constant);
    for (int i = 0; i < TestFixture::width; ++i) ASSERT_TRUE(same_bits(pack[i], constant)) << constant;
  }
}

TYPED_TEST(LaneLaws, WhatIsLoadedIsStored) {
  Random random(3);
  // Rows of any address: a pack need not be aligned.
  std::vector<double> from(64), to(64);
  for (double& v : from) v = draw(random);
  for (std::size_t i = 0; i + 8 < from.size(); ++i) {
    TypeParam::load(&from[i]).store(&to[i]);
    for (std::size_t j = 0; j < static_cast<std::size_t>(TestFixture::width); ++j) {
      ASSERT_TRUE(same_bits(from[i + j], to[i + j]));
    }
  }
}

TYPED_TEST(LaneLaws, PermutedLanesComeFromWhereTheyAreSaidTo) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const auto a = TestFixture::row(random);
    typename TypeParam::Bits from{};
    for (int i = 0; i < TestFixture::width; ++i) from[i] = static_cast<std::int64_t>(random() % a.size());
    const TypeParam result = permuted(TypeParam::load(a.data()), from);
    for (int i = 0; i < TestFixture::width; ++i) {
      ASSERT_TRUE(same_bits(result[i], a[static_cast<std::size_t>(from[i])]));
    }
  }
}

TEST(Lane, AFusedProductIsRoundedOnce) {
  const double a = 1.0 + 0x1p-30, tail = 0x1p-60;  // a^2 = 1 + 2^-29 + 2^-60, which a double lacks
  EXPECT_EQ(fma(a, a, -(1.0 + 0x1p-29)), tail);
  EXPECT_EQ(fma(NativeLane(a), NativeLane(a), NativeLane(-(1.0 + 0x1p-29)))[0], tail);
}

TEST(Lane, ClampKeepsItsBoundsAndWhatIsNotANumber) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const double x = draw(random), y = clamp(x, -1.0, 2.0);
    if (std::isnan(x)) {
      EXPECT_TRUE(std::isnan(y));
    } else {
      EXPECT_GE(y, -1.0);
      EXPECT_LE(y, 2.0);
      if (x >= -1.0 && x <= 2.0) {
        EXPECT_TRUE(same_bits(x, y));
      }
    }
  }
}

TEST(Lane, ARowHoldsWholePacksOfAnyWidthAndNoneTooMany) {
  for (int n = 0; n < 200; ++n) {
    EXPECT_EQ(padded(n) % row_quantum, 0);
    EXPECT_GE(padded(n), n);
    EXPECT_LT(padded(n), n + row_quantum);
  }
  EXPECT_EQ(row_quantum % native_width, 0);
}

}  // namespace
}  // namespace sightline
