#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

#include "sightline/loop.hpp"

namespace sightline {
namespace {

TEST(SpscQueue, AFullRingGivesNothingToWriteAndAnEmptyOneNothingToRead) {
  for (const std::size_t capacity : {1U, 2U, 5U}) {
    SpscQueue<int> ring(capacity, 0);
    EXPECT_EQ(ring.capacity(), capacity);
    for (int round = 0; round < 3; ++round) {
      EXPECT_EQ(ring.front(), nullptr);
      for (std::size_t i = 0; i < capacity; ++i) {
        ASSERT_NE(ring.claim(), nullptr);
        ring.publish();
      }
      EXPECT_EQ(ring.claim(), nullptr);
      for (std::size_t i = 0; i < capacity; ++i) {
        ASSERT_NE(ring.front(), nullptr);
        ring.pop();
        EXPECT_NE(ring.claim(), nullptr);
      }
    }
  }
}

TEST(SpscQueue, BetweenTwoThreadsNothingIsLostAndTheOrderIsKept) {
  struct Item {
    std::int64_t first = -1, second = -1;
  };
  for (const std::size_t capacity : {1U, 3U, 64U}) {
    const auto count = static_cast<std::int64_t>(1000 * capacity + 7);
    SpscQueue<Item> ring(capacity, {});
    std::thread producer([&] {
      for (std::int64_t i = 0; i < count; ++i) {
        Item* item = ring.claim();
        while (item == nullptr) {
          std::this_thread::yield();
          item = ring.claim();
        }
        *item = {i, -i};
        ring.publish();
      }
      ring.close();
    });
    std::int64_t expected = 0, broken = 0;
    while (const Item* item = ring.wait()) {
      if (item->first != expected || item->second != -expected) ++broken;
      ring.pop();
      ++expected;
    }
    producer.join();
    EXPECT_EQ(expected, count);
    EXPECT_EQ(broken, 0);
  }
}

}  // namespace
}  // namespace sightline
