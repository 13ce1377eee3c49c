#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"

namespace sightline {
namespace {

TEST(OrNan, WhatThrowsIsNotANumberAndWhatDoesNotIsItself) {
  EXPECT_EQ(or_nan([] { return 2.5; }), 2.5);
  EXPECT_TRUE(std::isnan(or_nan([]() -> double { throw std::runtime_error("no"); })));
  EXPECT_TRUE(std::isnan(or_nan([]() -> double { throw 3; })));
}

TEST(OrNan, WhatWasWrittenBeforeItThrewIsNotBelieved) {
  std::array<double, 3> a = {1, 2, 3};
  write_or_nan(a.data(), 2, [&] {
    a[0] = 7;
    throw std::runtime_error("no");
  });
  EXPECT_TRUE(std::isnan(a[0]) && std::isnan(a[1]));
  EXPECT_EQ(a[2], 3.0);
  write_or_nan(a.data(), 2, [&] { a[0] = a[1] = 4; });
  EXPECT_EQ(a, (std::array<double, 3>{4, 4, 3}));
}

}  // namespace
}  // namespace sightline
