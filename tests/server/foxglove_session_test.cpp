#include "sightline/server/foxglove_session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/connected_pair.hpp"
#include "tests/support/foxglove_ears.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

/// A session with two topics, and what its client hears.
struct TalkingPair {
  test::ConnectedPair pair;
  FoxgloveFeed feed{"paper"};
  SchemaId schema = feed.schema("P", "jsonschema", "{}");
  ChannelId a = feed.channel(schema, "/a", "json", {}), b = feed.channel(schema, "/b", "json", {});
  test::FoxgloveEars ears;
  std::optional<FoxgloveSession> session;

  TalkingPair() {
    pair.one.watch("", pair.now);
    session.emplace(feed, pair.one);
  }
  void receive(std::string_view text, WebsocketOp op = WebsocketOp::text) {
    session->receive({op, std::string(text)});
  }
  void feed_one(ChannelId channel, std::string_view bytes, std::uint64_t time = 7) {
    feed.message(channel, 0, time, std::as_bytes(std::span(bytes)));
    feed.hand_over(time);
    session->send(feed.take());
  }
  /// All that came.
  std::vector<test::FoxgloveEars::Heard> received() {
    std::vector<test::FoxgloveEars::Heard> list;
    do {
      pair.one.send(pair.now);
      for (std::string bytes = pair.receive(); !bytes.empty(); bytes = pair.receive()) ears.take(bytes);
    } while (pair.one.waiting() > 0);
    while (auto one = ears.next()) list.push_back(*std::move(one));
    return list;
  }
  /// The sentence of the status that came last.
  std::string status() {
    const auto all = received();
    if (all.empty() || all.back().op != WebsocketOp::text) return "";
    return all.back().json().value("message", "");
  }
};

TEST(FoxgloveSession, GreetsWithItselfAndItsTopics) {
  TalkingPair talk;
  const auto received = talk.received();
  ASSERT_EQ(received.size(), 2U);
  EXPECT_EQ(received[0].json()["op"], "serverInfo");
  EXPECT_EQ(received[0].json()["name"], "paper");
  EXPECT_EQ(received[1].json()["channels"].size(), 2U);
  EXPECT_EQ(test::advertised(received[1].json(), "/b"), 1U);
}

TEST(FoxgloveSession, TellsWhatWasSubscribedToUnderTheClientsIdAndTheTime) {
  TalkingPair talk;
  (void)talk.received();
  talk.receive(R"({"op":"subscribe","subscriptions":[{"id":42,"channelId":1}]})");
  talk.feed_one(talk.a, "not this");
  talk.feed_one(talk.b, "this", 1'000'000'007);
  auto received = talk.received();
  ASSERT_EQ(received.size(), 3U);  // two times, one message
  EXPECT_TRUE(received[1].is_message());
  EXPECT_EQ(received[1].subscription(), 42U);
  EXPECT_EQ(received[1].time(), 1'000'000'007U);
  EXPECT_EQ(received[1].bytes(), "this");
  EXPECT_EQ(received[2].payload, foxglove_time(1'000'000'007));
  talk.receive(R"({"op":"unsubscribe","subscriptionIds":[42]})");
  EXPECT_FALSE(talk.feed.is_requested());
  talk.feed_one(talk.b, "no more");
  EXPECT_EQ(talk.received().size(), 1U);
  EXPECT_EQ(talk.session->sent(), 1);
}

TEST(FoxgloveSession, WhoLeavesHasSubscribedToNothing) {
  TalkingPair talk;
  talk.receive(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0},{"id":1,"channelId":1}]})");
  EXPECT_TRUE(talk.feed.is_requested());
  talk.session.reset();
  EXPECT_FALSE(talk.feed.is_requested());
}

TEST(FoxgloveSession, RefusesByOneSentenceARequest) {
  TalkingPair talk;
  (void)talk.received();
  talk.receive(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":2},{"id":1,"channelId":99}]})");
  const auto received = talk.received();
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(received[0].json()["level"], 2);
  EXPECT_THAT(received[0].json()["message"].get<std::string>(),
              HasSubstr("channelId = 2, expected one that was advertised"));
  talk.receive(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0}]})");
  talk.receive(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":1}]})");
  EXPECT_THAT(talk.status(), HasSubstr("subscription id = 0"));
  talk.receive(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":0}]})");
  EXPECT_THAT(talk.status(), HasSubstr("not subscribed to already"));
  talk.receive(R"({"op":"unsubscribe","subscriptionIds":[7]})");
  EXPECT_THAT(talk.status(), HasSubstr("subscription id = 7"));
  talk.receive("nonsense");
  EXPECT_THAT(talk.status(), HasSubstr("no JSON object"));
  talk.receive("\x01garbage", WebsocketOp::binary);
  EXPECT_THAT(talk.status(), HasSubstr("a binary message, expected none"));
  EXPECT_TRUE(talk.feed.is_requested());  // what stood before stands
}

TEST(FoxgloveSession, TellsOfTopicsThatComeLater) {
  TalkingPair talk;
  (void)talk.received();
  talk.feed.channel(talk.schema, "/late", "json", {});
  talk.feed_one(talk.a, "x");
  const auto received = talk.received();
  ASSERT_EQ(received.size(), 2U);
  EXPECT_EQ(test::advertised(received[0].json(), "/late"), 2U);
  EXPECT_EQ(received[0].json()["channels"].size(), 1U);
}

TEST(FoxgloveSession, OfOneThatTakesNothingLittleWaitsAndWhatIsLeftOutIsCountedAndTold) {
  TalkingPair talk;
  talk.receive(R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":0}]})");
  const std::string long_one(100'000, 'x');
  for (int i = 0; i < 200; ++i) talk.feed_one(talk.a, long_one);
  EXPECT_LE(talk.pair.one.waiting(), FoxgloveSession::waiting_max + 1000);
  EXPECT_GT(talk.session->dropped(), 100);
  EXPECT_EQ(talk.session->sent() + talk.session->dropped(), 200);
  const std::int64_t left_out = talk.session->dropped();
  (void)talk.received();
  talk.feed_one(talk.a, "short again");
  const auto received = talk.received();
  ASSERT_EQ(received.size(), 3U);
  EXPECT_THAT(received[0].json()["message"].get<std::string>(),
              HasSubstr(fmt::format("{} messages were left out", left_out)));
  EXPECT_EQ(received[1].bytes(), "short again");
}

}  // namespace
}  // namespace sightline
