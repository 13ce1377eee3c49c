#include "sightline/server/http.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(Http, ARequestIsReadWithItsQueryAndHeaders) {
  const auto request = parse_request(
      "GET /live?a=1&token=ff HTTP/1.1\r\nHost: 127.0.0.1:80\r\nCONNECTION:  keep-alive, Upgrade \r\n");
  ASSERT_TRUE(request);
  EXPECT_EQ(request->method, "GET");
  EXPECT_EQ(request->path, "/live");
  EXPECT_EQ(request->parameter("token"), "ff");
  EXPECT_EQ(request->parameter("to"), "");
  EXPECT_EQ(request->header("host"), "127.0.0.1:80");
  EXPECT_TRUE(request->lists("connection", "upgrade"));
  EXPECT_FALSE(request->lists("connection", "up"));
}

TEST(Http, WhatIsNoPlainRequestIsRefused) {
  for (const char* head :
       {"", "GET", "GET / HTTP/1.0", "GET / HTTP/1.1 ", "GET  / HTTP/1.1", "GET http://x/ HTTP/1.1",
        "GET /\x01 HTTP/1.1", "GET / HTTP/1.1\r\nHost 1", "GET / HTTP/1.1\r\n: 1",
        "GET / HTTP/1.1\r\nHost: a\r\nhost: b", "GET / HTTP/1.1\r\n folded: 1",
        "POST / HTTP/1.1\r\nContent-Length: 5", "GET / HTTP/1.1\r\nTransfer-Encoding: chunked"})
    EXPECT_FALSE(parse_request(head)) << head;
}

TEST(Http, NoBytesAreTooWildToBeLookedAt) {
  std::mt19937_64 random(7);
  const std::string sound =
      "GET /live?token=1 HTTP/1.1\r\nHost: 127.0.0.1:80\r\nOrigin: http://127.0.0.1:80\r\n";
  for (int k = 0; k < 20'000; ++k) {
    std::string head = sound;
    for (int i = 0; i < 3; ++i) head[random() % head.size()] = static_cast<char>(random());
    head.resize(random() % (head.size() + 1));
    (void)parse_request(head);
  }
}

TEST(Http, EachAnswerForbidsForeignAndInlineScriptsFramesAndGuessesOfItsType) {
  const std::string answer = http_response(200, "text/html", "<p>");
  EXPECT_THAT(answer, HasSubstr("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(answer, HasSubstr("script-src 'self';"));
  EXPECT_THAT(answer, HasSubstr("default-src 'none'"));
  EXPECT_THAT(answer, HasSubstr("frame-ancestors 'none'"));
  EXPECT_THAT(answer, HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_THAT(answer, HasSubstr("Cross-Origin-Resource-Policy: same-origin"));
  EXPECT_EQ(answer.find("unsafe"), std::string::npos);
  EXPECT_TRUE(answer.ends_with("\r\n\r\n<p>"));
  EXPECT_TRUE(http_response(200, "text/html", "<p>", false).ends_with("\r\n\r\n"));
}

}  // namespace
}  // namespace sightline
