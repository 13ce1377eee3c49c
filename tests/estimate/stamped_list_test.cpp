#include "sightline/estimate/stamped_list.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

struct Item {
  double stamp = 0.0;
  int source = 0;
};
using List = StampedList<Item, 16>;

std::vector<std::pair<double, int>> content(const List& list) {
  std::vector<std::pair<double, int>> items;
  for (const Item& item : list) items.emplace_back(item.stamp, item.source);
  return items;
}

TEST(StampedList, ItsOrderIsThatOfStampsAndThenSourcesHoweverItWasFilled) {
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    List list;
    std::set<std::pair<double, int>> expected;
    while (!list.is_full()) {
      const Item item{std::floor(uniform(random, 0, 8)), static_cast<int>(uniform(random, 0, 4))};
      EXPECT_EQ(list.has(item), expected.contains({item.stamp, item.source}));
      if (!expected.emplace(item.stamp, item.source).second) continue;
      list.insert(item);
    }
    EXPECT_EQ(content(list), std::vector(expected.begin(), expected.end()));
  }
}

TEST(StampedList, FromATimeOnAreThoseThatAreNotBeforeIt) {
  List list;
  for (const double stamp : {3.0, 1.0, 2.0, 4.0}) list.insert({stamp, 0});
  EXPECT_EQ(std::distance(list.from(2.0), list.end()), 3);
  EXPECT_EQ(list.from(5.0), list.end());
  list.drop_before(2.5);
  EXPECT_EQ(content(list), (std::vector<std::pair<double, int>>{{3.0, 0}, {4.0, 0}}));
  list.clear();
  EXPECT_TRUE(list.empty());
}

}  // namespace
}  // namespace sightline
