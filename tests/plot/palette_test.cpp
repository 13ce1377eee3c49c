#include "sightline/plot/palette.hpp"

#include <gtest/gtest.h>

#include <set>

namespace sightline {
namespace {

TEST(Palette, EachColourIsAnotherAndHasSixDigits) {
  EXPECT_EQ(std::set<std::string_view>(palette.begin(), palette.end()).size(), palette.size());
  for (const std::string_view colour : palette) {
    ASSERT_EQ(colour.size(), 7U);
    EXPECT_EQ(colour[0], '#');
    EXPECT_EQ(colour.find_first_not_of("0123456789abcdef", 1), std::string_view::npos) << colour;
  }
}

}  // namespace
}  // namespace sightline
