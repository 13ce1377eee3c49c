#include "sightline/base/nearest.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace sightline {
namespace {

TEST(Nearest, ANameIsNearestToItselfAndWithOneLetterWrongStill) {
  const std::vector<std::string_view> known = {"wind",    "gust",  "airflow", "input_delay",
                                               "yaw_lag", "noise", "delay"};
  std::mt19937 random(1);
  for (const std::string_view name : known) {
    EXPECT_EQ(nearest(name, known), name);
    // One letter changed is still nearer to it than to any other of these.
    for (std::size_t i = 0; i < name.size(); ++i) {
      std::string wrong(name);
      wrong[i] = static_cast<char>('0' + random() % 10);
      EXPECT_EQ(nearest(wrong, known), name) << wrong;
    }
  }
}

}  // namespace
}  // namespace sightline
