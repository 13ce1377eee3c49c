#include "sightline/server/page_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <ctime>
#include <list>
#include <stdexcept>
#include <thread>
#include <vector>

#include "sightline/server/foxglove_feed.hpp"
#include "sightline/server/http.hpp"
#include "tests/support/foxglove_ears.hpp"
#include "tests/support/page_client.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::eventually;
using test::PageClient;
using testing::HasSubstr;
using testing::StartsWith;

PageFiles two_files() {
  return {{"/", {"text/html; charset=utf-8", "<p>page", true}},
          {"/scene.json", {"application/json", "{}", false}}};
}

PageServer on_loopback() { return PageServer({}, two_files()); }

TEST(PageServer, ServesItsFilesAndNothingElse) {
  const PageServer server = on_loopback();
  EXPECT_EQ(server.url(), fmt::format("http://127.0.0.1:{}/", server.port()));
  EXPECT_THAT(PageClient(server.port()).request("GET /"), HasSubstr("\r\n\r\n<p>page"));
  EXPECT_THAT(PageClient(server.port()).request("GET /scene.json"), HasSubstr("application/json"));
  EXPECT_TRUE(PageClient(server.port()).request("HEAD /scene.json").ends_with("\r\n\r\n"));
  EXPECT_THAT(PageClient(server.port()).request("GET /../etc/passwd"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(PageClient(server.port()).request("DELETE /"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(PageClient(server.port()).request("GET /live"), StartsWith("HTTP/1.1 400"));
}

TEST(PageServer, AFileCanBeMadeForEachRequestByWhatItAsks) {
  PageFiles files = two_files();
  files["/made.json"] = {.type = "application/json", .body = {}, .made = [](const HttpRequest& requested) {
                           return "from " + std::string(requested.parameter("from"));
                         }};
  const PageServer server({}, files);
  EXPECT_THAT(PageClient(server.port()).request("GET /made.json?from=7"), HasSubstr("\r\n\r\nfrom 7"));
  EXPECT_THAT(PageClient(server.port()).request("GET /made.json?from=8"), HasSubstr("\r\n\r\nfrom 8"));
  EXPECT_TRUE(PageClient(server.port()).request("HEAD /made.json?from=9").ends_with("\r\n\r\n"));
}

TEST(PageServer, WhatThrowsWhileItServesCostsThatClientAlone) {
  PageFiles files = two_files();
  files["/made.json"] = {
      .type = "application/json", .body = {}, .made = [](const HttpRequest&) -> std::string {
        throw std::runtime_error("no such row");
      }};
  const PageServer server({}, files, nullptr, [](std::string_view) { throw std::bad_alloc(); });
  const std::string answer = PageClient(server.port()).request("GET /made.json");
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 500 Internal Server Error"));
  EXPECT_THAT(answer, HasSubstr("this could not be made: no such row"));
  PageClient speaker(server.port());
  EXPECT_THAT(speaker.watch(), StartsWith("HTTP/1.1 101"));
  speaker.say(PageClient::masked(1, "{}"));
  (void)speaker.receive();
  EXPECT_TRUE(speaker.ended());
  EXPECT_THAT(PageClient(server.port()).request("GET /"), HasSubstr("<p>page"));
  EXPECT_TRUE(eventually([&] { return server.counts().refused == 2; }));
}

TEST(PageServer, AFileThatIsMadeSlowlyHoldsNobodyUpWhoPutsAnother) {
  std::atomic<bool> begun = false, go_on = false;
  PageFiles files = two_files();
  files["/slow.json"] = {.type = "application/json", .body = {}, .made = [&](const HttpRequest&) {
                           begun = true;
                           EXPECT_TRUE(eventually([&] { return go_on.load(); }));
                           return std::string("slow");
                         }};
  PageServer server({}, files);
  std::string answer;
  std::thread client([&] { answer = PageClient(server.port()).request("GET /slow.json"); });
  ASSERT_TRUE(eventually([&] { return begun.load(); }));
  server.put("/slow.json", {"application/json", "another"});  // does not wait for it
  go_on = true;
  client.join();
  EXPECT_TRUE(answer.ends_with("slow"));
  EXPECT_TRUE(PageClient(server.port()).request("GET /slow.json").ends_with("another"));
}

TEST(PageServer, WithoutADescriptorLeftItSleepsAndServesLater) {
  const PageServer server = on_loopback();
  std::vector<int> taken;
  for (int fd = 0; (fd = ::dup(STDIN_FILENO)) >= 0;) taken.push_back(fd);
  ASSERT_EQ(errno, EMFILE);
  ::close(taken.back());
  taken.pop_back();
  PageClient client(server.port());  // takes the last one
  EXPECT_TRUE(client.connected());
  const std::clock_t before = std::clock();  // of all threads
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_LT(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC, 0.2);
  for (const int fd : taken) ::close(fd);
  EXPECT_THAT(client.request("GET /"), HasSubstr("<p>page"));
}

TEST(PageServer, AWrongHostAndAForeignOriginAreRefusedForPagesAndWatchers) {
  const PageServer server = on_loopback();
  const auto own = fmt::format("http://127.0.0.1:{}", server.port());
  EXPECT_THAT(PageClient(server.port()).watch("Origin: " + own + "\r\n"), StartsWith("HTTP/1.1 101"));
  EXPECT_THAT(PageClient(server.port()).watch("Origin: http://attacker.example\r\n"),
              StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(PageClient(server.port()).request("GET /", "Origin: http://attacker.example\r\n"),
              StartsWith("HTTP/1.1 403"));
  PageClient rebound(server.port());
  rebound.say(fmt::format("GET / HTTP/1.1\r\nHost: attacker.example:{}\r\n\r\n", server.port()));
  EXPECT_THAT(rebound.receive(), StartsWith("HTTP/1.1 403"));
  EXPECT_TRUE(eventually([&] { return server.counts().refused == 3; }));
}

TEST(PageServer, OnOtherAddressesATokenIsAskedForOnceInTheUrl) {
  const PageServer server({.address = "0.0.0.0"}, two_files());
  const std::string token = server.url().substr(server.url().find("token="));
  EXPECT_GE(token.size(), 6U + 32U);
  EXPECT_THAT(PageClient(server.port()).request("GET /"),
              StartsWith("HTTP/1.1 200"));  // the program of the page
  EXPECT_THAT(PageClient(server.port()).request("GET /scene.json"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(PageClient(server.port()).request("GET /scene.json?" + token), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(PageClient(server.port()).watch(), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(PageClient(server.port()).watch("", "/live?token=0123"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(PageClient(server.port()).watch("", "/live?" + token), StartsWith("HTTP/1.1 101"));
}

TEST(PageServer, TopicsAreForOwnAndAllowedOriginsAndForNoPage) {
  FoxgloveFeed feed("paper");
  const PageServer server({.origins = {"https://app.foxglove.dev"}}, two_files(), &feed);
  const auto requested = [&](std::string_view more, std::string_view path = "/") {
    return PageClient(server.port()).ask_for_topics(more, path);
  };
  EXPECT_THAT(requested(""), StartsWith("HTTP/1.1 101"));
  EXPECT_THAT(requested("Origin: https://app.foxglove.dev\r\n"), StartsWith("HTTP/1.1 101"));
  EXPECT_THAT(requested(fmt::format("Origin: http://127.0.0.1:{}\r\n", server.port())),
              StartsWith("HTTP/1.1 101"));
  for (const char* origin : {"null", "file://", "http://attacker.example"})
    EXPECT_THAT(requested(fmt::format("Origin: {}\r\n", origin)), StartsWith("HTTP/1.1 403")) << origin;
  // The flight's own state stays with its own page.
  EXPECT_THAT(requested("Origin: https://app.foxglove.dev\r\n", "/live"), StartsWith("HTTP/1.1 403"));
  EXPECT_THROW(PageServer({.origins = {"null"}}, two_files(), &feed), std::invalid_argument);
}

TEST(PageServer, OneThatTakesNoTopicsIsClosedAndWhatItMissedIsCounted) {
  FoxgloveFeed feed("paper");
  const ChannelId a = feed.channel(feed.schema("P", "jsonschema", "{}"), "/a", "json", {});
  const PageServer server({}, two_files(), &feed);
  PageClient reader(server.port()), deaf(server.port(), 4096);
  test::FoxgloveEars ears;
  for (PageClient* one : {&reader, &deaf}) {
    ASSERT_THAT(one->ask_for_topics(), StartsWith("HTTP/1.1 101"));
    one->say(test::subscribe_frame(0, 0));
    ASSERT_TRUE(eventually([&] { return feed.is_requested(); }));
  }
  ASSERT_TRUE(eventually([&] { return server.counts().watchers == 2; }));
  const std::string long_one(300'000, 'x');
  std::int64_t received = 0, fed = 0;
  while (server.counts().closed == 0 && fed < 3000) {
    feed.message(a, 0, static_cast<std::uint64_t>(++fed), std::as_bytes(std::span(long_one)));
    feed.hand_over(static_cast<std::uint64_t>(fed));
    for (bool reported = false; !reported;) {  // the reader hears each
      const auto message = ears.next(reader);
      ASSERT_TRUE(message);
      if (!(reported = message->is_message())) continue;
      if (received == 0) received = static_cast<std::int64_t>(message->time()) - 1;
      EXPECT_EQ(message->time(), static_cast<std::uint64_t>(++received));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(server.counts().closed, 1);
  EXPECT_TRUE(eventually([&] { return server.counts().messages_dropped > 0; }));
}

TEST(PageServer, AWatcherHearsTheNewestStateAtOnceAndThenEachNext) {
  PageServer server = on_loopback();
  server.post("old");
  server.post("first");
  PageClient client(server.port());
  EXPECT_THAT(client.watch(), HasSubstr("Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"));
  EXPECT_EQ(client.receive("first"),
            "\x81\x05"
            "first");
  server.post("second");
  EXPECT_EQ(client.receive("second"),
            "\x81\x06"
            "second");
  client.say(PageClient::masked(9, "hi"));
  EXPECT_EQ(client.receive("hi"),
            "\x8a\x02"
            "hi");
}

TEST(PageServer, LongMessagesAndManyCloseTheirWatcherAlone) {
  PageServer server = on_loopback();
  PageClient quiet(server.port()), longer(server.port()), many(server.port());
  for (PageClient* one : {&quiet, &longer, &many}) ASSERT_THAT(one->watch(), StartsWith("HTTP/1.1 101"));
  longer.say(PageClient::masked(1, std::string(1'000'000, 'x')));
  longer.receive();
  EXPECT_TRUE(longer.ended());
  std::string flood;
  for (int i = 0; i < 10'000; ++i) flood += PageClient::masked(1, "x");
  many.say(flood);
  many.receive();
  EXPECT_TRUE(many.ended());
  EXPECT_TRUE(eventually([&] { return server.counts().closed == 2; }));
  server.post("still here");
  EXPECT_THAT(quiet.receive("still here"), HasSubstr("still here"));
}

// Half-open ones fill all room, and give it back; nobody who came before is disturbed.
TEST(PageServer, ALongHeadIsRefused) {
  const PageServer server = on_loopback();
  PageClient client(server.port());
  client.say("GET / HTTP/1.1\r\nX: " + std::string(100'000, 'x'));
  client.receive();
  EXPECT_TRUE(client.ended());
  EXPECT_TRUE(eventually([&] { return server.counts().refused == 1; }));
}

TEST(PageServer, WhoSaysNothingIsClosedAndMoreThanThereIsRoomForAreRefused) {
  PageServer server = on_loopback();
  PageClient watcher(server.port());
  ASSERT_THAT(watcher.watch(), StartsWith("HTTP/1.1 101"));
  std::list<PageClient> silent;
  for (std::size_t i = 0; i < PageServer::connections_max + 10; ++i) silent.emplace_back(server.port());
  EXPECT_TRUE(eventually([&] { return server.counts().refused == 11; }));
  server.post("as ever");
  EXPECT_THAT(watcher.receive("as ever"), HasSubstr("as ever"));
  EXPECT_TRUE(
      eventually([&] { return PageClient(server.port()).request("GET /").starts_with("HTTP/1.1 200"); },
                 std::chrono::duration<double>(2 * PageServer::patience)));
}

TEST(PageServer, AWatcherThatReadsNothingDelaysNobodyAndIsClosed) {
  PageServer server = on_loopback();
  PageClient reader(server.port()), deaf(server.port(), 4096);
  ASSERT_THAT(reader.watch(), StartsWith("HTTP/1.1 101"));
  ASSERT_THAT(deaf.watch(), StartsWith("HTTP/1.1 101"));
  ASSERT_TRUE(eventually([&] { return server.counts().watchers == 2; }));
  const std::string state(200'000, 's');
  double slowest = 0.0;
  const auto began = std::chrono::steady_clock::now();
  bool closed = false;
  for (int k = 0; !closed && k < 1000; ++k) {
    const std::string last = fmt::format("number {};", k);
    const auto before = std::chrono::steady_clock::now();
    server.post(state + last);
    slowest =
        std::max(slowest, std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count());
    ASSERT_THAT(reader.receive(last), HasSubstr(last));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    closed = server.counts().closed == 1;
  }
  EXPECT_TRUE(closed) << "after "
                      << std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count()
                      << " s";
  EXPECT_LT(slowest, 1.0);  // a socket that is waited for takes PageServer::patience
  EXPECT_EQ(server.counts().watchers, 1);
}

TEST(PageServer, AnotherServerTakesThePortOfOneThatEnded) {
  std::uint16_t port = 0;
  {
    PageServer server = on_loopback();
    port = server.port();
    PageClient client(port);
    ASSERT_THAT(client.watch(), StartsWith("HTTP/1.1 101"));
    EXPECT_THROW(PageServer({.port = port}, two_files()), std::invalid_argument);
  }
  PageServer server({.port = port}, two_files());
  EXPECT_THAT(PageClient(port).request("GET /"), StartsWith("HTTP/1.1 200"));
}

TEST(PageServer, AnAddressThatIsNoneIsRefusedByItsName) {
  EXPECT_THAT(refusal_of([] { PageServer({.address = "localhost"}, two_files()); }),
              HasSubstr("address = localhost, expected an IPv4 address"));
}

}  // namespace
}  // namespace sightline
