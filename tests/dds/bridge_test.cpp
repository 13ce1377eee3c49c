#include "bridges/dds/fleet/bridge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/links.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

struct NoBridge final : Bridge {
  std::unique_ptr<LinkedWorld> connect(const Scenario&) const override { return nullptr; }
  std::unique_ptr<VehicleSimulators> vehicle_simulator(const Scenario&) const override { return nullptr; }
  std::unique_ptr<FleetDoctor> examine(const Scenario&) const override { return nullptr; }
};

const std::string text_of_fleet =
    "[fleet]\n[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n[agent.a.link]\nkind = "
    "\"ros2\"\nodometry = \"/o\"\n"
    "cmd_vel = \"/c\"\n";

// A fleet is read by programs that cannot fly it, and by those that can: what is read is the same.
TEST(Bridge, AFleetIsReadWithAndWithoutOne) {
  Registry registry = with_links();
  EXPECT_EQ(registry.bridge, nullptr);
  registry.bridge = std::make_shared<NoBridge>();
  const Scenario with = parse_scenario(text_of_fleet, "a.toml", registry);
  EXPECT_EQ(summary(with), summary(test::scenario_of(text_of_fleet)));
  EXPECT_EQ(with.registry->bridge, registry.bridge);
}

TEST(Links, AProgramWithoutTheirReaderRefusesThemAlone) {
  const auto refusal = [](const std::string& text) {
    return refusal_of<ScenarioError>([&] { parse_scenario(text, "a.toml"); });
  };
  EXPECT_EQ(refusal(text_of_fleet),
            "a.toml:1: fleet = {...}, expected no links: this program lacks their reader, with_links()");
  EXPECT_THAT(refusal(text_of_fleet.substr(text_of_fleet.find('\n') + 1)),
              testing::EndsWith("agent.a.link = {...}, expected no such table without a [fleet]"));
}

}  // namespace
}  // namespace sightline
