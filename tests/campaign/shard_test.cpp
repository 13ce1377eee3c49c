#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "sightline/analysis.hpp"

namespace sightline {
namespace {

TEST(Shard, AllShardsAreAllRunsEachOnceCountedFromNoughtOrFromOne) {
  for (const int of : {1, 2, 3, 8, 13}) {
    for (const int runs : {1, 7, 8, 100}) {
      for (const int from : {0, 1}) {
        std::multiset<int> all;
        for (int number = from; number < of + from; ++number) {
          const Shard shard{number, of};
          for (int i = 0; i < shard.size(runs); ++i) all.insert(shard.run(i));
        }
        ASSERT_EQ(static_cast<int>(all.size()), runs);
        for (int k = 0; k < runs; ++k) EXPECT_EQ(all.count(k), 1U) << k << ", " << of << " shards";
      }
    }
  }
}

TEST(Shard, IsReadAsItIsWritten) {
  EXPECT_EQ(shard_of("3/8"), (Shard{3, 8}));
  EXPECT_EQ(to_string(shard_of("3/8")), "3/8");
  EXPECT_EQ(to_string(shard_of("0/8")), "8/8") << "the same runs";
  EXPECT_TRUE(shard_of("1/1").is_whole());
}

TEST(Shard, WhatIsNoShardIsRefused) {
  for (const char* text :
       {"", "3", "/8", "3/", "9/8", "-1/8", "3/0", "3/8/1", "a/b", "3 / 8", "1/10001", "1/99999999999"}) {
    EXPECT_THROW((void)shard_of(text), std::invalid_argument) << text;
  }
}

}  // namespace
}  // namespace sightline
