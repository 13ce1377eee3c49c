#include "sightline/scenario/bridge.hpp"

#include <gtest/gtest.h>

#include "sightline/scenario/parts.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

struct NoBridge final : Bridge {
  std::unique_ptr<LinkedWorld> connect(const Scenario&) const override { return nullptr; }
  std::unique_ptr<StandIns> stand_in(const Scenario&) const override { return nullptr; }
  std::unique_ptr<FleetDoctor> examine(const Scenario&) const override { return nullptr; }
};

// A fleet is read by programs that cannot fly it, and by those that can: what is read is the same.
TEST(Bridge, AFleetIsReadWithAndWithoutOne) {
  const std::string text =
      "[fleet]\n[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n[agent.a.link]\nkind = "
      "\"ros2\"\nodometry = \"/o\"\n"
      "cmd_vel = \"/c\"\n";
  Parts parts;
  EXPECT_EQ(parts.bridge, nullptr);
  EXPECT_EQ(parts_of_sightline().bridge, nullptr);
  parts.bridge = std::make_shared<NoBridge>();
  const Scenario with = parse_scenario(text, "a.toml", parts);
  EXPECT_EQ(summary(with), summary(test::scenario_of(text)));
  EXPECT_EQ(with.parts->bridge, parts.bridge);
}

}  // namespace
}  // namespace sightline
