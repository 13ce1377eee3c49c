#include "sightline/server/foxglove_feed.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <thread>

namespace sightline {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

bool is_readable(const FoxgloveFeed& feed) {
  pollfd polled{feed.fd(), POLLIN, 0};
  return ::poll(&polled, 1, 0) == 1;
}

TEST(FoxgloveFeed, KeepsMessagesOfTopicsThatSomebodyHasSubscribedToAlone) {
  FoxgloveFeed feed("paper");
  const SchemaId schema = feed.schema("P", "jsonschema", "{}");
  const ChannelId a = feed.channel(schema, "/a", "json", {}), b = feed.channel(schema, "/b", "json", {});
  EXPECT_FALSE(feed.is_requested());
  feed.message(a, 0, 10, bytes_of("unheard"));
  feed.subscribed(b);
  EXPECT_TRUE(feed.is_requested());
  feed.message(a, 1, 20, bytes_of("unheard"));
  feed.message(b, 0, 20, bytes_of("heard"));
  EXPECT_FALSE(is_readable(feed));
  feed.hand_over(25);
  EXPECT_TRUE(is_readable(feed));
  const auto batches = feed.take();
  EXPECT_FALSE(is_readable(feed));
  ASSERT_EQ(batches.size(), 1U);
  EXPECT_EQ(batches[0].time, 25U);
  ASSERT_EQ(batches[0].messages.size(), 1U);
  EXPECT_EQ(batches[0].messages[0].channel, b);
  EXPECT_EQ(batches[0].messages[0].time, 20U);
  EXPECT_EQ(batches[0].bytes, "heard");
  feed.unsubscribed(b);
  EXPECT_FALSE(feed.is_requested());
}

TEST(FoxgloveFeed, TopicsMayComeLater) {
  FoxgloveFeed feed("paper");
  const SchemaId schema = feed.schema("P", "jsonschema", "{}");
  feed.channel(schema, "/a", "json", {});
  feed.channel(schema, "/b", "json", {});
  EXPECT_EQ(feed.channel_count(), 2U);
  const auto later = feed.channels(1);
  ASSERT_EQ(later.size(), 1U);
  EXPECT_EQ(later[0].id, 1U);
  EXPECT_EQ(later[0].topic, "/b");
  EXPECT_EQ(later[0].schema_name, "P");
  EXPECT_EQ(later[0].schema_encoding, "jsonschema");
}

TEST(FoxgloveFeed, WhatNobodyServesIsBoundedAndCounted) {
  FoxgloveFeed feed("paper");
  const ChannelId a = feed.channel(feed.schema("P", "jsonschema", "{}"), "/a", "json", {});
  feed.subscribed(a);
  const std::string long_one(1 << 20, 'x');
  for (int i = 0; i < 100; ++i) {
    feed.message(a, 0, 0, bytes_of(long_one));
    feed.hand_over(0);
  }
  std::size_t waiting = 0, messages = 0;
  for (const auto& batch : feed.take()) waiting += batch.bytes.size(), messages += batch.messages.size();
  EXPECT_LE(waiting, FoxgloveFeed::waiting_max);
  EXPECT_GT(messages, 0U);
  EXPECT_EQ(feed.dropped(), static_cast<std::int64_t>(100 - messages));
}

TEST(FoxgloveFeed, OneThreadFeedsWhileAnotherServes) {
  FoxgloveFeed feed("paper");
  const SchemaId schema = feed.schema("P", "jsonschema", "{}");
  const ChannelId a = feed.channel(schema, "/a", "json", {});
  feed.subscribed(a);
  constexpr int count = 2000;
  std::thread feeding([&] {
    for (int i = 0; i < count; ++i) {
      feed.message(a, 0, static_cast<std::uint64_t>(i), bytes_of("m"));
      if (i % 500 == 0) feed.channel(schema, "/more", "json", {});
      feed.hand_over(static_cast<std::uint64_t>(i));
    }
  });
  std::uint64_t next = 0;
  while (next < count)
    for (const auto& batch : feed.take())
      for (const auto& message : batch.messages) {
        EXPECT_EQ(message.time, next++);
        (void)feed.channels(0);
        feed.subscribed(a);
        feed.unsubscribed(a);
      }
  feeding.join();
  EXPECT_EQ(feed.channel_count(), 5U);
}

}  // namespace
}  // namespace sightline
