#include "sightline/server/connection.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

#include "sightline/server/http.hpp"
#include "tests/support/page_client.hpp"

namespace sightline {
namespace {

using State = Connection::State;

/// A connection, and the other end of it.
struct ConnectedPair {
  std::array<int, 2> fds = [] {
    std::array<int, 2> both{};
    ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, both.data());
    return both;
  }();
  OwnedDescriptor other{fds[1]};
  Connection::Time now = std::chrono::steady_clock::now();
  Connection one{OwnedDescriptor(fds[0]), now, 1024, 3};

  void say(std::string_view bytes) {
    ASSERT_EQ(::write(fds[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  std::string hear() const {
    std::string heard(1'000'000, ' ');
    const ssize_t n = ::read(fds[1], heard.data(), heard.size());
    heard.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return heard;
  }
};

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
  EXPECT_EQ(pair.hear(), "fine");
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
  std::string heard;
  while (heard.size() < state.size() + 7) {
    const std::string more = pair.hear();
    ASSERT_FALSE(more.empty());
    heard += more;
    pair.one.send(pair.now);
  }
  EXPECT_EQ(heard, "head;" + state + websocket_frame(WebsocketOp::ping, ""));
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
  EXPECT_EQ(pair.hear(), websocket_close(WebsocketClose::against_the_rules));
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

}  // namespace
}  // namespace sightline
