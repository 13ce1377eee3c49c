#include "sightline/server/websocket.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/page_client.hpp"

namespace sightline {
namespace {

using test::PageClient;

TEST(Websocket, TheAnswerToAKeyIsThatOfTheStandard) {
  // RFC 6455, 1.3
  EXPECT_EQ(websocket_accept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  EXPECT_TRUE(is_websocket_key("dGhlIHNhbXBsZSBub25jZQ=="));
  for (const char* key :
       {"", "dGhlIHNhbXBsZSBub25jZQ", "dGhlIHNhbXBsZSBub25j\r\n==", "dGhlIHNhbXBsZSBub25jZQaa"})
    EXPECT_FALSE(is_websocket_key(key)) << key;
}

TEST(Websocket, FramesSayTheirLengthInTheShortestForm) {
  const auto head = [](std::size_t n) {
    const std::string frame = websocket_frame(WebsocketOp::text, std::string(n, 'x'));
    return frame.size() - n;
  };
  EXPECT_EQ(websocket_frame(WebsocketOp::text, "Hello"), "\x81\x05Hello");
  EXPECT_EQ(head(125), 2U);
  EXPECT_EQ(head(126), 4U);
  EXPECT_EQ(head(65535), 4U);
  EXPECT_EQ(head(65536), 10U);
  EXPECT_EQ(websocket_close(WebsocketClose::too_long), std::string("\x88\x02\x03\xf1"));
}

TEST(Websocket, FramesArriveHoweverTheyAreCut) {
  const std::string bytes = PageClient::masked(1, "Hello") + PageClient::masked(9, "") +
                            PageClient::masked(1, std::string(200, 'y'));
  for (std::size_t piece = 1; piece < 20; ++piece) {
    WebsocketReader reader(256);
    std::string reported;
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
      reader.take(std::string_view(bytes).substr(at, piece));
      while (const auto frame = reader.next())
        reported += std::to_string(static_cast<int>(frame->op)) + frame->payload;
    }
    EXPECT_EQ(reported, "1Hello91" + std::string(200, 'y'));
    EXPECT_FALSE(reader.fault());
  }
}

TEST(Websocket, ALongFrameIsRefusedByItsHeadAlone) {
  for (const std::string& head :
       {std::string("\x81\xfe\x04\x01", 4), std::string("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff", 10)}) {
    WebsocketReader reader(1024);
    reader.take(head);
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.fault(), WebsocketClose::too_long);
  }
}

TEST(Websocket, WhatTheStandardForbidsIsRefused) {
  for (const std::string& bytes :
       {std::string("\x81\x05Hello"), std::string("\xc1\x80", 2), std::string("\x83\x80", 2),
        std::string("\x09\x80", 2), std::string("\x89\xfe", 2)}) {
    WebsocketReader reader(1024);
    reader.take(bytes);
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.fault(), WebsocketClose::not_the_protocol);
  }
}

TEST(Websocket, NoBytesAreTooWildToBeLookedAt) {
  std::mt19937_64 random(3);
  for (int k = 0; k < 2'000; ++k) {
    WebsocketReader reader(1024);
    for (int i = 0; i < 20 && !reader.fault(); ++i) {
      std::string bytes(random() % 300, ' ');
      for (char& c : bytes) c = static_cast<char>(random());
      reader.take(bytes);
      while (const auto frame = reader.next()) EXPECT_LE(frame->payload.size(), 1024U);
    }
  }
}

}  // namespace
}  // namespace sightline
