#include "sightline/base/bounded.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace sightline {
namespace {

struct Counted {
  static inline int made = 0;
  int number = 0;
  Counted(int n) : number(n) { ++made; }
};

TEST(Bounded, HoldsWhatWasAddedInItsOrder) {
  Bounded<int, 4> list;
  EXPECT_TRUE(list.empty());
  for (const int item : {3, 1, 4}) EXPECT_EQ(list.push_back(item), item);
  EXPECT_EQ(list.size(), 3U);
  EXPECT_FALSE(list.is_full());
  EXPECT_EQ(std::accumulate(list.begin(), list.end(), 0), 8);
  list[1] = 5;
  const Bounded<int, 4> copy = list;
  list.push_back(9);
  EXPECT_TRUE(list.is_full());
  EXPECT_EQ(copy.size(), 3U);
  EXPECT_EQ(copy[1], 5);
  list.clear();
  EXPECT_EQ(list.begin(), list.end());
}

TEST(Bounded, MakesNothingThatWasNotAdded) {
  Bounded<Counted, 50> list;
  EXPECT_EQ(Counted::made, 0);
  list.push_back(7);
  EXPECT_EQ(list[0].number, 7);
  EXPECT_EQ(Counted::made, 1);
}

}  // namespace
}  // namespace sightline
