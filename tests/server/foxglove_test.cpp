#include "sightline/server/foxglove.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

namespace sightline {
namespace {

using testing::HasSubstr;

TEST(Foxglove, TheFirstOfAClientsProtocolsThatIsOursIsSpoken) {
  EXPECT_EQ(foxglove_protocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(foxglove_protocol("x, foxglove.sdk.v1 ,foxglove.websocket.v1"), "foxglove.sdk.v1");
  for (const char* none : {"", ",", " ", "foxglove", "foxglove.websocket.v10", "foxglove.websocket.v1 x"})
    EXPECT_EQ(foxglove_protocol(none), "") << none;
}

TEST(Foxglove, TextMessagesAreThoseOfTheProtocol) {
  const auto info = nlohmann::json::parse(foxglove_server_info("paper", "s1"));
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["name"], "paper");
  EXPECT_EQ(info["capabilities"], nlohmann::json::array({"time"}));
  EXPECT_EQ(info["sessionId"], "s1");
  const std::vector<FoxgloveChannel> channels = {
      {7, "/a/pose", "cdr", "geometry_msgs/msg/PoseStamped", "ros2msg", "float64 \"x\"\n"}};
  EXPECT_EQ(nlohmann::json::parse(foxglove_advertise(channels)), nlohmann::json::parse(R"({
    "op": "advertise",
    "channels": [{"id": 7, "topic": "/a/pose", "encoding": "cdr", "schemaName": "geometry_msgs/msg/PoseStamped",
                  "schemaEncoding": "ros2msg", "schema": "float64 \"x\"\n"}]})"));
  EXPECT_EQ(nlohmann::json::parse(foxglove_status(FoxgloveLevel::error, "no \xff")),
            nlohmann::json::parse(R"({"op": "status", "level": 2, "message": "no \ufffd"})"));
}

TEST(Foxglove, BinaryMessagesAreLittleEndian) {
  using namespace std::string_literals;
  EXPECT_EQ(foxglove_message(0x01020304, 0x1122334455667788, "xy"),
            "\x01\x04\x03\x02\x01\x88\x77\x66\x55\x44\x33\x22\x11xy"s);
  EXPECT_EQ(foxglove_time(258), "\x02\x02\x01\0\0\0\0\0\0"s);
}

TEST(Foxglove, ClientsSubscribeAndUnsubscribe) {
  const auto more = read_foxglove(
      R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":4294967295,"channelId":0}]})");
  const auto& subscriptions = std::get<FoxgloveSubscribe>(more).subscriptions;
  ASSERT_EQ(subscriptions.size(), 2U);
  EXPECT_EQ(subscriptions[0].channel, 3U);
  EXPECT_EQ(subscriptions[1].id, 4294967295U);
  const auto less = read_foxglove(R"({"op":"unsubscribe","subscriptionIds":[5,6]})");
  EXPECT_EQ(std::get<FoxgloveUnsubscribe>(less).ids, (std::vector<std::uint32_t>{5, 6}));
}

TEST(Foxglove, WhatIsNoRequestIsRefusedByASentence) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "no JSON object"},
      {"{", "no JSON object"},
      {"[]", "no JSON object"},
      {"\xff\xfe", "no JSON object"},
      {std::string(20'000, '['), "no JSON object"},
      {"{}", "no \"op\""},
      {R"({"op":7})", "no \"op\""},
      {R"({"op":"setParameters","parameters":[]})", "op = setParameters, expected subscribe or unsubscribe"},
      {R"({"op":"advertise"})", "only publishes"},
      {R"({"op":"subscribe"})", "no list \"subscriptions\""},
      {R"({"op":"subscribe","subscriptions":[[]]})", "\"channelId\""},
      {R"({"op":"subscribe","subscriptions":[{"id":0}]})", "\"channelId\""},
      {R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})", "expected numbers"},
      {R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})", "expected numbers"},
      {R"({"op":"subscribe","subscriptions":[{"id":0.5,"channelId":1}]})", "expected numbers"},
      {R"({"op":"unsubscribe","subscriptionIds":3})", "no list \"subscriptionIds\""},
      {R"({"op":"unsubscribe","subscriptionIds":["3"]})", "no number"}};
  for (const auto& [text, why] : cases) {
    const auto answer = read_foxglove(text);
    ASSERT_TRUE(std::holds_alternative<FoxgloveRefused>(answer)) << text.substr(0, 80);
    EXPECT_THAT(std::get<FoxgloveRefused>(answer).why, HasSubstr(why));
    EXPECT_LT(foxglove_status(FoxgloveLevel::error, std::get<FoxgloveRefused>(answer).why).size(), 300U);
  }
}

TEST(Foxglove, NoBytesAreTooWildToBeRead) {
  std::mt19937 random(1);
  const std::string sound = R"({"op":"subscribe","subscriptions":[{"id":0,"channelId":3}]})";
  for (int run = 0; run < 20'000; ++run) {
    std::string text = sound;
    for (int k = 0; k < 3; ++k) text[random() % text.size()] = static_cast<char>(random());
    (void)read_foxglove(text);
  }
}

}  // namespace
}  // namespace sightline
