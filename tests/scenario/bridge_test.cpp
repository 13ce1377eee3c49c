#include "sightline/scenario/bridge.hpp"

#include <gtest/gtest.h>

#include "sightline/scenario/registry.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

struct NoBridge final : Bridge {
  std::unique_ptr<LinkedWorld> connect(const Scenario&) const override { return nullptr; }
  std::unique_ptr<VehicleSimulators> vehicle_simulator(const Scenario&) const override { return nullptr; }
  std::unique_ptr<FleetDoctor> examine(const Scenario&) const override { return nullptr; }
};

// A fleet is read by programs that cannot fly it, and by those that can: what is read is the same.
TEST(Bridge, AFleetIsReadWithAndWithoutOne) {
  const std::string text =
      "[fleet]\n[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n[agent.a.link]\nkind = "
      "\"ros2\"\nodometry = \"/o\"\n"
      "cmd_vel = \"/c\"\n";
  Registry registry;
  EXPECT_EQ(registry.bridge, nullptr);
  EXPECT_EQ(built_in_registry().bridge, nullptr);
  registry.bridge = std::make_shared<NoBridge>();
  const Scenario with = parse_scenario(text, "a.toml", registry);
  EXPECT_EQ(summary(with), summary(test::scenario_of(text)));
  EXPECT_EQ(with.registry->bridge, registry.bridge);
}

}  // namespace
}  // namespace sightline
