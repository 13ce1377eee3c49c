#include "sightline/scenario/read_motion.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sightline {
namespace {

constexpr AgentId followed{BodyId{3}};

UncooperativeStart uncooperative(const std::string& text) {
  const TomlDocument document = parse_toml(text, "a");
  return read_uncooperative(TomlTable(document), [](const TomlTable& at) {
    EXPECT_EQ(at.text("agent", "a name"), "uav3");
    return followed;
  });
}

template <class M>
M motion(const std::string& text) {
  return std::get<M>(*uncooperative("p = [1.0, 2.0, 3.0]\nmotion = " + text).uncooperative.motion);
}

void expect_same(const Vec3<double>& a, const Vec3<double>& b) { EXPECT_EQ(norm(a - b), 0.0); }

TEST(ReadMotion, EachParameterOfAMotionReachesItsStruct) {
  const auto chase = motion<ChaseMotion>("{ chase = { agent = \"uav3\", speed = 0.7, standoff = 0.2 } }");
  EXPECT_EQ(std::tie(chase.agent.index, chase.speed, chase.standoff), std::make_tuple(3, 0.7, 0.2));

  const auto cross =
      motion<CrossMotion>("{ cross = { agent = \"uav3\", at = 4.0, speed = 0.7, miss = -0.3 } }");
  EXPECT_EQ(std::tie(cross.agent.index, cross.at, cross.speed, cross.miss),
            std::make_tuple(3, 4.0, 0.7, -0.3));

  const auto hand = motion<HandMotion>(
      "{ hand = { agent = \"uav3\", at = 4.0, from = [4.0, 5.0, 6.0], speed = 0.7, standoff = 0.3 } }");
  EXPECT_EQ(std::tie(hand.agent.index, hand.at, hand.speed, hand.standoff),
            std::make_tuple(3, 4.0, 0.7, 0.3));
  expect_same(hand.from, {4, 5, 6});

  const auto adversary = motion<AdversaryMotion>(
      "{ adversary = { agent = \"uav3\", speed = 0.7, every = 0.2, aim = 0.9, within = \"space\" } }");
  EXPECT_EQ(std::tie(adversary.agent.index, adversary.speed, adversary.every, adversary.aim),
            std::make_tuple(3, 0.7, 0.2, 0.9));
  EXPECT_EQ(adversary.within, AdversaryMotion::Within::space);
}

TEST(ReadMotion, APathAndACircleSayThemselvesWhereTheyBegin) {
  const UncooperativeStart path = uncooperative(
      "motion = { path = { points = [[4.0, 5.0, 6.0], [7.0, 8.0, 9.0]], speed = 0.7, end = \"round\" } }");
  expect_same(path.p, {4, 5, 6});
  const auto& on_path = std::get<PathMotion>(*path.uncooperative.motion);
  EXPECT_EQ(on_path.speed, 0.7);
  EXPECT_EQ(on_path.end, PathMotion::End::round);
  ASSERT_EQ(on_path.points.size(), 2U);
  expect_same(on_path.points[1], {7, 8, 9});

  const UncooperativeStart circle = uncooperative(
      "motion = { circle = { centre = [4.0, 5.0, 6.0], radius = 0.5, rate = -0.7, phase = 0.0 } }");
  expect_same(circle.p, {4.5, 5, 6});
  EXPECT_EQ(std::get<CircleMotion>(*circle.uncooperative.motion).rate, -0.7);
  EXPECT_DOUBLE_EQ(top_speed(*circle.uncooperative.motion), 0.35);
}

TEST(ReadMotion, WhatStandsStillIsTakenToStayAndAnyOtherToBeFast) {
  const std::string place = "p = [1.0, 2.0, 3.0]\n";
  EXPECT_EQ(uncooperative(place).uncooperative.speed_max, 0.0);
  EXPECT_EQ(uncooperative(place + "v = [0.1, 0.0, 0.0]").uncooperative.speed_max, 1.5);
  EXPECT_EQ(uncooperative(place + "motion = { chase = { agent = \"uav3\" } }").uncooperative.speed_max, 1.5);
  EXPECT_EQ(uncooperative(place + "speed_max = 0.3").uncooperative.speed_max, 0.3);
}

constexpr std::string_view motion_scene = R"(
[agent.uav0]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0 }
[target.lamp]
motion = { circle = { centre = [0.0, 0.0, 1.0], radius = 0.5, rate = 0.6 } }
[obstacle.wall]
p = [3.0, 0.0, 1.0]
[obstacle.dog]
p = [4.0, 0.0, 1.0]
motion = { chase = { agent = "uav0", speed = 0.5 } }
velocity = "unknown"
d_hard = 0.8
)";

TEST(ReadMotion, AScenariosUncooperativeBodiesReachItsPlantAndItsSensor) {
  const Scenario s = parse_scenario(std::string(motion_scene), "a.toml");
  ASSERT_EQ(s.uncooperative.size(), 3U);
  const PlantOptions plant = plant_options(s);
  ASSERT_EQ(plant.motions.size(), 2U);
  EXPECT_EQ(plant.motions[0].body, s.team.find("lamp"));
  EXPECT_EQ(plant.motions[1].body, s.team.find("dog"));
  EXPECT_EQ(std::get<ChaseMotion>(plant.motions[1].motion).agent, s.team.find("uav0"));
  EXPECT_EQ(sensor_options(s).velocity_unknown, std::vector{s.team.find("dog")});
  EXPECT_THAT(
      summary(s),
      testing::AllOf(testing::HasSubstr(
                         "target      lamp, circle at up to 0.3 m/s, velocity measured, speed_max 1.5 m/s\n"),
                     testing::HasSubstr("obstacle    wall, velocity measured, speed_max 0 m/s\n"),
                     testing::HasSubstr(
                         "obstacle    dog, chase uav0 at up to 0.5 m/s, velocity unknown, speed_max 1.5 m/s, "
                         "d_hard 0.8 m\n")));
}

}  // namespace
}  // namespace sightline
