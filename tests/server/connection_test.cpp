#include "sightline/server/connection.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "sightline/server/http.hpp"
#include "tests/support/connected_pair.hpp"
#include "tests/support/page_client.hpp"

namespace sightline {
namespace {

using test::ConnectedPair;
using State = Connection::State;

TEST(Connection, AHeadIsWholeAtItsEmptyLine) {
  ConnectedPair pair;
  pair.say("GET / HTTP/1.1\r\nA: b\r\n");
  pair.one.receive(pair.now);
  EXPECT_EQ(pair.one.head(), "");
  pair.say("\r\n");
  pair.one.receive(pair.now);
  EXPECT_EQ(pair.one.head(), "GET / HTTP/1.1\r\nA: b");
  pair.one.answer("fine", pair.now);
  pair.one.send(pair.now);
  EXPECT_EQ(pair.receive(), "fine");
  EXPECT_EQ(pair.one.state(), State::closed);
}

TEST(Connection, OfAHeadWithoutAnEndNoMoreIsKeptThanItsLimit) {
  ConnectedPair pair;
  for (int i = 0; i < 10; ++i) {
    pair.say(std::string(4096, 'x'));
    pair.one.receive(pair.now);
  }
  EXPECT_TRUE(pair.one.head_too_long());
}

TEST(Connection, TheEndOfTheStreamClosesIt) {
  ConnectedPair pair;
  pair.other = OwnedDescriptor();
  ::shutdown(pair.fds[1], SHUT_RDWR);
  pair.one.receive(pair.now);
  EXPECT_EQ(pair.one.state(), State::closed);
}

TEST(Connection, AStateThatIsNotTakenWaitsAndNothingComesBetweenItsBytes) {
  ConnectedPair pair;
  pair.one.watch("head;", pair.now);
  pair.one.send(pair.now);
  const std::string state(3'000'000, 's');
  pair.one.give(std::make_shared<const std::string>(state), 7, pair.now);
  pair.one.send(pair.now);
  EXPECT_TRUE(pair.one.sends());
  EXPECT_EQ(pair.one.given(), 7);
  pair.one.ping(pair.now);
  std::string received;
  while (received.size() < state.size() + 7) {
    const std::string more = pair.receive();
    ASSERT_FALSE(more.empty());
    received += more;
    pair.one.send(pair.now);
  }
  EXPECT_EQ(received, "head;" + state + websocket_frame(WebsocketOp::ping, ""));
  EXPECT_FALSE(pair.one.sends());
}

TEST(Connection, AWatcherThatSendsTooMuchIsToldWhyAndClosed) {
  ConnectedPair pair;
  pair.one.watch("", pair.now);
  pair.one.send(pair.now);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(pair.one.state(), State::watching);
    pair.say(test::PageClient::masked(1, "x"));
    pair.one.receive(pair.now);
  }
  EXPECT_EQ(pair.one.state(), State::closed);
  EXPECT_TRUE(pair.one.broke_rules());
  EXPECT_EQ(pair.receive(), websocket_close(WebsocketClose::against_the_rules));
}

TEST(Connection, AWatcherThatEndsIsAnsweredByItsOwnCode) {
  for (const std::string& why :
       {std::string(), std::string("\x03\xe8", 2), std::string("\x03\xe9 I go", 7)}) {
    ConnectedPair pair;
    pair.one.watch("", pair.now);
    pair.one.send(pair.now);
    pair.say(test::PageClient::masked(8, why));
    pair.one.receive(pair.now);
    EXPECT_EQ(pair.one.state(), State::closed);
    EXPECT_FALSE(pair.one.broke_rules());
    EXPECT_EQ(pair.receive(), websocket_frame(WebsocketOp::close, why.substr(0, 2)));
  }
}

TEST(Connection, AWatcherMaySendAFewEachSecond) {
  ConnectedPair pair;
  pair.one.watch("", pair.now);
  pair.one.send(pair.now);
  for (int i = 0; i < 12; ++i) {
    pair.say(test::PageClient::masked(1, "x"));
    pair.one.receive(pair.now + i * std::chrono::milliseconds(400));
  }
  EXPECT_EQ(pair.one.state(), State::watching);
}

TEST(Connection, AMessageInPartsIsPutTogetherAndControlFramesMayComeBetween) {
  ConnectedPair pair;
  pair.one.watch("", pair.now);
  pair.one.allow(1024, 100);
  pair.one.send(pair.now);
  const auto part = [](unsigned first, std::string_view payload) {
    std::string frame = test::PageClient::masked(0, payload);
    frame[0] = static_cast<char>(first);
    return frame;
  };
  pair.say(part(0x01, "a") + test::PageClient::masked(9, "") + part(0x00, "b") + part(0x80, "c") +
           test::PageClient::masked(2, "d"));
  pair.one.receive(pair.now);
  const auto messages = pair.one.take_messages();
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_EQ(messages[0].payload, "abc");
  EXPECT_EQ(messages[0].op, WebsocketOp::text);
  EXPECT_EQ(messages[1].payload, "d");
  EXPECT_TRUE(pair.one.take_messages().empty());
  // A part without a begin, a begin within a message, and parts that are too long together.
  for (const std::string& wrong : {part(0x80, "x"), part(0x01, "x") + part(0x01, "y"),
                                   part(0x01, "x") + part(0x00, std::string(1024, 'y'))}) {
    ConnectedPair other;
    other.one.watch("", other.now);
    other.one.send(other.now);
    other.say(wrong);
    other.one.receive(other.now);
    EXPECT_EQ(other.one.state(), State::closed);
    EXPECT_TRUE(other.one.broke_rules());
  }
}

TEST(Connection, OfManyLongMessagesNoMoreThanTwentyASecondAreTaken) {
  ConnectedPair pair;
  pair.one.watch("", pair.now);
  pair.one.allow(1024, 1000);
  pair.one.send(pair.now);
  int taken = 0;
  for (; taken < 100 && pair.one.state() == State::watching; ++taken) {
    pair.say(test::PageClient::masked(1, std::string(1000, 'x')));
    pair.one.receive(pair.now);
  }
  EXPECT_EQ(taken, 21);
  EXPECT_TRUE(pair.one.broke_rules());
}

}  // namespace
}  // namespace sightline
