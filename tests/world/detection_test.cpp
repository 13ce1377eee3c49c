#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "sightline/world.hpp"

namespace sightline {
namespace {

TEST(Detection, TheCovarianceHasOnePlaceForEachPairOfErrors) {
  std::set<std::size_t> places;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = i; j < 6; ++j) {
      EXPECT_EQ(Detection::place(i, j), Detection::place(j, i));
      EXPECT_TRUE(places.insert(Detection::place(i, j)).second);
    }
  }
  EXPECT_EQ(places.size(), Detection{}.covariance.size());
  EXPECT_EQ(*places.rbegin(), 20U);
  EXPECT_EQ(Detection::place(0, 5), 5U) << "row by row";
  EXPECT_EQ(Detection::place(1, 1), 6U);
}

TEST(Detection, ItsCovarianceComesBackAsAMatrix) {
  Mat<6, 6> all;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) all(i, j) = 10 * std::min(i, j) + std::max(i, j);
  Detection seen;
  seen.set_covariance(all);
  EXPECT_EQ(seen.covariance_matrix(), all);
  EXPECT_EQ(seen.covariance[Detection::place(2, 4)], 24);
}

}  // namespace
}  // namespace sightline
