#include <gtest/gtest.h>

#include <array>
#include <cstddef>

#include "sightline/base.hpp"

namespace sightline {
namespace {

template <class L>
class Transpose : public testing::Test {};
using Widths = testing::Types<Lane<1>, Lane<2>, Lane<4>, Lane<8>>;
TYPED_TEST_SUITE(Transpose, Widths);

TYPED_TEST(Transpose, ExchangesRowsAndColumns) {
  constexpr int W = TypeParam::width;
  std::array<TypeParam, static_cast<std::size_t>(W)> rows;
  for (int i = 0; i < W; ++i) {
    for (int j = 0; j < W; ++j) rows[static_cast<std::size_t>(i)].v[j] = 10 * i + j;
  }
  transpose(rows);
  for (int i = 0; i < W; ++i) {
    for (int j = 0; j < W; ++j) EXPECT_EQ(rows[static_cast<std::size_t>(i)][j], 10 * j + i);
  }
}

TYPED_TEST(Transpose, TheFirstNumbersAloneAreStored) {
  constexpr int W = TypeParam::width;
  TypeParam pack;
  for (int i = 0; i < W; ++i) pack.v[i] = i + 1;
  for (int count = 0; count <= W; ++count) {
    std::array<double, static_cast<std::size_t>(W)> to{};
    store_first(pack, count, to.data());
    for (int i = 0; i < W; ++i)
      EXPECT_EQ(to[static_cast<std::size_t>(i)], i < count ? i + 1 : 0) << count << ' ' << i;
  }
}

}  // namespace
}  // namespace sightline
