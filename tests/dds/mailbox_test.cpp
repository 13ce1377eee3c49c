#include "bridges/dds/topics/mailbox.hpp"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace sightline::dds {
namespace {

TEST(Mailbox, GivesWhatWasPutLastAndNothingBefore) {
  Mailbox<int> box;
  int value = -1;
  EXPECT_FALSE(box.look(value));
  EXPECT_EQ(value, -1);
  box.put(7);
  box.put(8);
  EXPECT_TRUE(box.look(value));
  EXPECT_EQ(value, 8);
  EXPECT_EQ(box.count(), 2u);
}

// A value that is half old and half new would have numbers that differ.
TEST(Mailbox, AValueIsWholeWhileAnotherThreadPuts) {
  using Letter = std::array<std::uint64_t, 20>;
  Mailbox<Letter> box;
  std::atomic<bool> done{false};
  std::jthread writer([&] {
    Letter letter{};
    while (!done) {
      letter.fill(letter[0] + 1);
      box.put(letter);
    }
  });
  Letter seen{};
  std::uint64_t last = 0;
  for (int looks = 0; looks < 100'000;) {
    if (!box.look(seen)) continue;
    ++looks;
    for (const std::uint64_t n : seen) EXPECT_EQ(n, seen[0]);
    EXPECT_GE(seen[0], last);
    last = seen[0];
  }
  done = true;
  writer.join();
  ASSERT_TRUE(box.look(seen));
  EXPECT_EQ(seen[19], box.count());
}

}  // namespace
}  // namespace sightline::dds
