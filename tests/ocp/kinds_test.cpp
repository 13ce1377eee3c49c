#include "sightline/ocp/event/kinds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Kinds, AreVisitedInTheOrderOfTheirList) {
  std::vector<std::size_t> sizes;
  for_each_kind<std::variant<char, double, char>>([&]<class K>(Kind<K>) { sizes.push_back(sizeof(K)); });
  EXPECT_THAT(sizes, testing::ElementsAre(1U, 8U, 1U));
}

}  // namespace
}  // namespace sightline
