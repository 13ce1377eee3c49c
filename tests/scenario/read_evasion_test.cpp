#include <gtest/gtest.h>

#include "sightline/scenario/read_campaign.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

Team evasion_team() {
  Team team;
  team.add(Multirotor{}, {.name = "uav0"});
  team.add(Obstacle{.name = "lamp"});
  team.add(Obstacle{.name = "hand"});
  return team;
}

EvasionPlan plan(const std::string& text) {
  const TomlDocument document = parse_toml(text, "a");
  return read_evasion(TomlTable(document), evasion_team());
}

std::string evasion_refusal(const std::string& text) {
  return refusal_of<ScenarioError>([&] { plan(text); });
}

const std::string evasion_names = "agent = \"uav0\"\ntarget = \"lamp\"\nobstacle = \"hand\"\n";

TEST(ReadEvasion, EachKeyReachesItsField) {
  const EvasionPlan read =
      plan(evasion_names +
           "from = 12.0\nd_obstacle = 1.5\nd_min = 0.6\nd_max = 2.5\nalpha = 0.4\n"
           "published = { min_obstacle = [1.0, 1.1], min_target = [1.2, 1.3], max_target = [1.4, 1.5], "
           "max_angle = [0.1, 0.2] }");
  EXPECT_EQ(std::tie(read.agent, read.target, read.obstacle), std::make_tuple("uav0", "lamp", "hand"));
  EXPECT_EQ(std::tie(read.from, read.d_obstacle, read.d_min, read.d_max, read.alpha),
            std::make_tuple(12.0, 1.5, 0.6, 2.5, 0.4));
  EXPECT_EQ(read.published.min_obstacle, (std::vector{1.0, 1.1}));
  EXPECT_EQ(read.published.min_target, (std::vector{1.2, 1.3}));
  EXPECT_EQ(read.published.max_target, (std::vector{1.4, 1.5}));
  EXPECT_EQ(read.published.max_angle, (std::vector{0.1, 0.2}));
  EXPECT_TRUE(plan(evasion_names).published.min_obstacle.empty());
}

TEST(ReadEvasion, WhatCannotBeIsRefusedWithItsLine) {
  EXPECT_EQ(evasion_refusal("agent = \"lamp\"\ntarget = \"lamp\"\nobstacle = \"hand\""),
            "a:1: agent = \"lamp\", expected a robot: uav0");
  EXPECT_EQ(evasion_refusal("agent = \"uav0\"\ntarget = \"lamq\"\nobstacle = \"hand\""),
            "a:2: target = \"lamq\", expected another body, the nearest is \"lamp\"");
  EXPECT_EQ(evasion_refusal(evasion_names + "d_min = 0.0"), "a:4: d_min = 0, expected > 0 m");
  EXPECT_EQ(
      evasion_refusal(evasion_names +
                      "published = { min_obstacle = [1.0], min_target = [1.0, 2.0], max_target = [1.0], "
                      "max_angle = [1.0] }"),
      "a:4: published.min_target = [1, 2], expected an array of 1 numbers");
  EXPECT_EQ(evasion_refusal(evasion_names + "form = 1.0"),
            "a:4: form = 1, expected a known key, the nearest is \"from\"");
}

}  // namespace
}  // namespace sightline
