#include "cli/fault_keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline::cli {
namespace {

std::vector<std::pair<std::size_t, LinkFaultKind>> asked_by(std::string_view keys) {
  FaultTyping typing;
  std::vector<std::pair<std::size_t, LinkFaultKind>> all;
  for (const char key : keys)
    if (const auto requested = typing.take(key)) all.emplace_back(requested->robot, requested->kind);
  return all;
}

TEST(FaultKeys, ALetterIsAFaultOfTheRobotWhoseNumberWasTypedLast) {
  using K = LinkFaultKind;
  using All = std::vector<std::pair<std::size_t, K>>;
  EXPECT_EQ(asked_by("d"), (All{{0, K::drop}}));
  EXPECT_EQ(asked_by("2sp"), (All{{1, K::silent}, {1, K::pilot}}));
  EXPECT_EQ(asked_by("2s1s"), (All{{1, K::silent}, {0, K::silent}}));
  EXPECT_EQ(asked_by("12\nw"), (All{{11, K::wrong_release}}));
  EXPECT_EQ(asked_by("0d?A \n"), All{});
  EXPECT_EQ(asked_by("99999999999999d"), (All{{999'999, K::drop}}));
}

TEST(FaultKeys, HelpNamesEachFault) {
  FaultTyping typing;
  EXPECT_FALSE(typing.take('?'));
  EXPECT_TRUE(typing.asks_for_help());
  (void)typing.take('d');
  EXPECT_FALSE(typing.asks_for_help());
  for (const LinkFaultText& fault : link_faults)
    EXPECT_THAT(fault_keys_help(),
                testing::HasSubstr(std::string("  ") + fault.key + "  " + std::string(fault.name)));
}

}  // namespace
}  // namespace sightline::cli
