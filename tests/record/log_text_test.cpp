#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "sightline/log.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

TEST(LogText, ReadsEveryNumberBackToTheSameBits) {
  std::mt19937_64 random(1);
  LogText text;
  std::vector<double> values = {0.0, -0.0, 1.0, -1.0, 1e300, 5e-324, 0.1, 123456789012345678.0};
  while (values.size() < 2000) {
    const double value = std::bit_cast<double>(random());
    if (std::isfinite(value)) values.push_back(value);
  }
  McapWriter mcap(test::fresh_folder() / "run.mcap", "ros2", "");
  LogMessage message(mcap);
  message.begin(values[5]);
  message.put("x", values);
  text.read(message.end());
  EXPECT_EQ(text.number("time"), values[5]);
  const std::span<const double> read = text.numbers("x");
  ASSERT_EQ(read.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_EQ(std::bit_cast<std::uint64_t>(read[i]), std::bit_cast<std::uint64_t>(values[i])) << values[i];
}

TEST(LogText, NullStandsForANumberThatWasNotFinite) {
  McapWriter mcap(test::fresh_folder() / "run.mcap", "ros2", "");
  LogMessage message(mcap);
  message.begin(std::numeric_limits<double>::infinity());
  message.put("x", std::array{1.0, std::nan("")});
  LogText text;
  const std::string line(message.end());
  EXPECT_EQ(line, "{\"time\":null,\"x\":[1,null]}");
  text.read(line);
  EXPECT_TRUE(std::isnan(text.number("time")));
  EXPECT_TRUE(std::isnan(text.numbers("x")[1]));
}

TEST(LogMessage, WritesWordsWholeNumbersAndTruth) {
  McapWriter mcap(test::fresh_folder() / "run.mcap", "ros2", "");
  LogMessage message(mcap);
  message.begin(1.5);
  message.put("target", "uav1");
  message.put("tags", 2);
  message.put("active", true);
  message.put("reserve", -0.25);
  const std::string line(message.end());
  EXPECT_EQ(line, R"({"time":1.5,"target":"uav1","tags":2,"active":true,"reserve":-0.25})");
}

TEST(LogText, KeysStandInAnyOrderWithAnySpaceAsOtherWritersLeaveThem) {
  LogText text;
  text.read(
      " { \"x\" : [ 1.50 , -2e-3 ,\n3 ] , \"kind\" : \"late \\\" plan\" , \"on\" : true , \"time\" : 4 , "
      "\"none\" : [ ] } ");
  EXPECT_EQ(text.number("time"), 4.0);
  EXPECT_EQ(text.numbers("x")[1], -2e-3);
  EXPECT_EQ(text.word("kind"), "late \\\" plan");
  EXPECT_TRUE(text.numbers("none").empty());
}

TEST(LogText, WhatIsNoMessageIsRefusedAndNothingIsReadBehindItsEnd) {
  LogText text;
  const std::string good = R"({"time":1.5,"x":[1,null,-2.5e-3],"kind":"a\"b","on":false})";
  text.read(good);
  for (const char* bad : {"", "{", "[]", "{\"a\"}", "{\"a\":}", "{\"a\":1,}", "{\"a\":[1,]}", "{\"a\":inf}",
                          "{\"a\":nan}", "{\"a\":1e999}", "{\"a\":1}x", "{\"a\":{}}", "{\"a", "{\"a\":\"b"})
    EXPECT_THROW(text.read(bad), std::runtime_error) << bad;
  std::mt19937 random(2);
  int read = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string spoilt = good.substr(0, 1 + random() % good.size());
    for (int flips = 0; flips < 3; ++flips) spoilt[random() % spoilt.size()] = static_cast<char>(random());
    const std::string exact(spoilt.data(), spoilt.size());  // whatever lies behind is another's
    try {
      text.read(exact);
      ++read;
    } catch (const std::runtime_error&) {
    }
  }
  EXPECT_LT(read, 10'000);
}

TEST(LogText, WhatIsMissingOrOfAnotherKindIsToldByItsName) {
  LogText text;
  text.read(R"({"time":1,"x":[1]})");
  EXPECT_EQ(refusal_of<std::runtime_error>([&] { (void)text.number("x"); }),
            "a message without \"x\", expected a number");
  EXPECT_EQ(refusal_of<std::runtime_error>([&] { (void)text.numbers("u"); }),
            "a message without \"u\", expected a list of numbers");
  EXPECT_EQ(refusal_of<std::runtime_error>([&] { (void)text.word("time"); }),
            "a message without \"time\", expected a word");
}

}  // namespace
}  // namespace sightline
