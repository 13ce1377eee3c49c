#include "sightline/base/c_callback.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace sightline {
namespace {

std::string reports;

int by_size(const void* a, const void* b) {
  const int one = *static_cast<const int*>(a), other = *static_cast<const int*>(b);
  if (one == 13 || other == 13) throw std::runtime_error("thirteen");
  return one - other;
}

static_assert(std::is_same_v<decltype(c_callback<by_size>), int (*const)(const void*, const void*) noexcept>);

TEST(CCallback, ThrowsNothingThroughTheFramesOfALibrary) {
  reports.clear();
  report_failures_to([](std::string_view line) noexcept { reports += line; });
  std::vector<int> numbers = {3, 1, 2};
  std::qsort(numbers.data(), numbers.size(), sizeof(int), c_callback<by_size>);
  EXPECT_EQ(numbers, (std::vector<int>{1, 2, 3}));
  numbers = {13, 1, 2, 13};
  for (int i = 0; i < 3; ++i) std::qsort(numbers.data(), numbers.size(), sizeof(int), c_callback<by_size>);
  report_failures_to(nullptr);
  EXPECT_EQ(reports, "sightline: a callback has ended: thirteen\n");
}

}  // namespace
}  // namespace sightline
