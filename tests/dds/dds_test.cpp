#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/command_line.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

TEST(Dds, IsTheBridgeOfThePartsThatItIsAddedToOnce) {
  Registry registry;
  add_dds(registry);
  EXPECT_NE(registry.bridge, nullptr);
  EXPECT_EQ(refusal_of([&] { add_dds(registry); }), "there is a bridge already, expected one");
}

const std::string text_of_fleet =
    "[fleet]\n[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n[agent.a.link]\nkind = "
    "\"ros2\"\nodometry = \"/o\"\ncmd_vel = \"/c\"\n";

// What a program that can fly a fleet reads is what others read.
TEST(Dds, AFleetIsReadWithAndWithoutIt) {
  Registry registry;
  add_dds(registry);
  EXPECT_EQ(summary(parse_scenario(text_of_fleet, "a.toml", registry)),
            summary(test::scenario_of(text_of_fleet)));
}

TEST(Links, AProgramWithoutTheirReaderRefusesThemAlone) {
  const auto refusal = [](const std::string& text) {
    return refusal_of<ScenarioError>([&] { parse_scenario(text, "a.toml"); });
  };
  EXPECT_EQ(refusal(text_of_fleet),
            "a.toml:1: fleet = {}, expected no links: this program lacks their reader, with_links()");
  EXPECT_THAT(refusal(text_of_fleet.substr(text_of_fleet.find('\n') + 1)),
              testing::EndsWith("agent.a.link = {...}, expected no such table without a [fleet]"));
}

}  // namespace
}  // namespace sightline
