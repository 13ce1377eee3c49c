#include "sightline/base/bounded.hpp"

#include <gtest/gtest.h>

namespace sightline {
namespace {

struct Counted {
  static inline int made = 0;
  int number = 0;
  Counted(int n) : number(n) { ++made; }
};

TEST(Bounded, MakesNothingThatWasNotAdded) {
  Bounded<Counted, 50> list;
  EXPECT_EQ(Counted::made, 0);
  list.push_back(7);
  EXPECT_EQ(list[0].number, 7);
  EXPECT_EQ(Counted::made, 1);
}

}  // namespace
}  // namespace sightline
