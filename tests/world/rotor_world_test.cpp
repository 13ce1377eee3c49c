#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "sightline/robots.hpp"
#include "sightline/world/rotorcraft.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/copied.hpp"
#include "tests/support/hexacopter.hpp"
#include "tests/support/mixed_fleet.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using test::copied;
using test::mixed_fleet;
using Numbers = std::vector<double>;
using testing::HasSubstr;

const Numbers fleet_start = {0, 0, 2, 0.6, 0.8, 0.3, 0.1, /**/ 3, 0,   0,      1, 0, 0.2, 0, /**/
                             6, 0, 3, 1,   0,   0,   0,   0.2,    0.1, /**/ 9, 0, 1, 0.1, 0, 0};
const std::vector<RobotVehicle> fleet = {{BodyId{0}, Vehicle::x500(), "x500"},
                                         {BodyId{2}, Vehicle::crazyflie(), "crazyflie"}};
const Numbers fleet_input = {0.3, -0.2, 0.1, 0.4, /**/ 0.5, 0.1, -0.2, /**/ 0.4, 0.3, 0.2, 0.3};

Numbers part(std::span<const double> x, std::size_t from, std::size_t n) {
  return copied(x.subspan(from, n));
}

Numbers fly(RotorWorld& world, int periods, const Numbers& inputs = fleet_input) {
  Numbers seen;
  for (int k = 0; k < periods; ++k) {
    const Measured now = world.measure(0.01 * k);
    seen.insert(seen.end(), now.measured.begin(), now.measured.end());
    seen.insert(seen.end(), now.truth.begin(), now.truth.end());
    EXPECT_TRUE(test::apply(world, 0.01 * k, now.measured, inputs, 0.01, 1)) << world.ended();
  }
  return seen;
}

TEST(RotorWorld, WhoIsNoVehicleMovesAsInTheModelWorldBitForBit) {
  RotorWorld rotors(mixed_fleet(), fleet_start, fleet);
  ModelWorld models(mixed_fleet(), fleet_start);
  for (int k = 0; k < 100; ++k) {
    const Measured seen = rotors.measure(0.01 * k), expected = models.measure(0.01 * k);
    EXPECT_EQ(part(seen.truth, 7, 7), part(expected.truth, 7, 7));
    EXPECT_EQ(part(seen.measured, 23, 6), part(expected.measured, 23, 6));
    if (k > 10) {
      EXPECT_NE(part(seen.truth, 0, 7), part(expected.truth, 0, 7));
    }
    ASSERT_TRUE(test::apply(rotors, 0.01 * k, {}, fleet_input, 0.01, 1));
    ASSERT_TRUE(test::apply(models, 0.01 * k, {}, fleet_input, 0.01, 1));
  }
}

TEST(RotorWorld, MeasuresTheStateOfThePlanningModelAsTheBodyShowsIt) {
  RotorWorld world(mixed_fleet(), fleet_start, fleet);
  EXPECT_EQ(copied(world.measure(0.0).truth), copied(world.start()));
  fly(world, 80);
  const Numbers x = copied(world.measure(0.8).truth);
  for (const auto& [robot, from] : {std::pair{BodyId{0}, 0}, std::pair{BodyId{2}, 14}}) {
    const Rotorcraft* const craft = world.rotorcraft(robot);
    ASSERT_NE(craft, nullptr);
    const double* const state = &x[static_cast<std::size_t>(from)];
    const RigidBody& body = craft->body();
    EXPECT_EQ((Numbers{state[0], state[1], state[2]}), (Numbers{body.p.x, body.p.y, body.p.z}));
    const Vec2<double> v = rotate<double>({state[3], state[4]}, {state[5], state[6]});
    EXPECT_NEAR(v.x, body.v.x, 1e-12);
    EXPECT_NEAR(v.y, body.v.y, 1e-12);
    EXPECT_NEAR(norm(state[3], state[4]), 1.0, 1e-15);
    EXPECT_LT(craft->attitude().z.z, 0.9999) << "it tilts";
  }
  EXPECT_EQ(x[14 + 7], world.rotorcraft(BodyId{2})->body().v.z);
  EXPECT_EQ(x[14 + 8], world.rotorcraft(BodyId{2})->heading_rate());
  EXPECT_EQ(world.rotorcraft(BodyId{1}), nullptr);
}

TEST(RotorWorld, TellsTheTrueAttitudeOfItsVehiclesAndOfNobodyElse) {
  RotorWorld world(mixed_fleet(), fleet_start, fleet);
  fly(world, 60);
  const auto attitudes = world.measure(0.6).attitudes;
  ASSERT_EQ(attitudes.size(), 4u);
  for (const int vehicle : {0, 2}) {
    const Rotorcraft* const craft = world.rotorcraft(BodyId{vehicle});
    EXPECT_EQ(attitudes[static_cast<std::size_t>(vehicle)], craft->body().q);
    EXPECT_GT(norm(lean(craft->attitude()).x, lean(craft->attitude()).y), 0.01) << "it leans";
  }
  EXPECT_EQ(attitudes[1], no_attitude);
  EXPECT_EQ(attitudes[3], no_attitude);
  EXPECT_TRUE(ModelWorld(mixed_fleet(), fleet_start).measure(0.0).attitudes.empty());
}

TEST(RotorWorld, AnAngleMultirotorShowsItsAngle) {
  Team team;
  team.add(AngleMultirotor{}, {.name = "uav"});
  RotorWorld world(std::move(team), {0, 0, 2, 3.0, 0.2, -0.1}, {{BodyId{0}, hexacopter(), "x500"}});
  const Numbers command = {0, 0, 0, 0.5};
  double turned = 0.0, before = 3.0;
  for (int k = 0; k < 300; ++k) {
    ASSERT_TRUE(test::apply(world, 0.01 * k, {}, command, 0.01, 1));
    const double psi = world.measure(0.01 * (k + 1)).truth[3];
    EXPECT_LE(std::abs(psi), 3.1415927);
    turned += wrap_angle(psi - before);
    before = psi;
  }
  EXPECT_NEAR(turned, 0.8 * 3, 0.25);
}

TEST(RotorWorld, ALaggingHoverMultirotorShowsTheAccelerationOfItsTiltTheClimbAndTheYawRate) {
  Team team;
  team.add(LaggingHoverMultirotor{}, {.name = "uav"});
  RotorWorld world(std::move(team), {0, 0, 3, 0.6, 0.8, 0, 0, 0, 0, 0, 0},
                   {{BodyId{0}, Vehicle::x500(), "x500"}});
  fly(world, 150, {0.5, -1.0, 0.0, 0.0});
  const Numbers x = copied(world.measure(1.5).truth);
  const Rotorcraft* const craft = world.rotorcraft(BodyId{0});
  EXPECT_NEAR(x[7], gravity * std::tan(0.5 * 0.2), 0.02);
  EXPECT_NEAR(x[8], gravity * std::tan(0.2), 0.02) << "u_s > 0 is to the right";
  EXPECT_EQ(x[9], craft->body().v.z);
  EXPECT_EQ(x[10], craft->heading_rate());
}

TEST(RotorWorld, PeriodsThatWereMissedPassUnderTheInputsThatWentOn) {
  RotorWorld at_once(mixed_fleet(), fleet_start, fleet), one_by_one(mixed_fleet(), fleet_start, fleet);
  ASSERT_TRUE(test::apply(at_once, 0.0, {}, fleet_input, 0.01, 25));
  for (int k = 0; k < 25; ++k) ASSERT_TRUE(test::apply(one_by_one, 0.01 * k, {}, fleet_input, 0.01, 1));
  EXPECT_EQ(copied(at_once.measure(0.25).truth), copied(one_by_one.measure(0.25).truth));
}

TEST(RotorWorld, WindDriftsAVehicleThatHoldsItsTilt) {
  const auto drifted = [](const Vehicle& vehicle) {
    Team team;
    team.add(Multirotor{}, {.name = "uav"});
    RotorWorld world(std::move(team), {0, 0, 2, 1, 0, 0, 0}, {{BodyId{0}, vehicle, ""}},
                     {.disturbances = {.wind = {1.0, 0, 0}}});
    fly(world, 50, {0, 0, 0, 0});
    return world.measure(0.5).truth[5];
  };
  // v = air (1 - e^{-d t / m}) where the tilt stays 0: the drag falls with the speed.
  for (const auto& preset : Vehicle::presets()) {
    const double rate = preset.part.hover_drag().x / preset.part.mass;
    const double air = preset.part.air({1, 0, 0}).x;
    EXPECT_NEAR(drifted(preset.part), air * (1 - std::exp(-0.5 * rate)), 0.02) << preset.name;
  }
}

TEST(RotorWorld, WhoIsAbsentRestsAndWhoJoinsBeginsAtTheStart) {
  RotorWorld world(mixed_fleet(), fleet_start, fleet);
  using enum Presence;
  world.set_presence(std::array{steered, steered, absent, hold});
  for (int k = 0; k < 100; ++k) {
    EXPECT_EQ(part(world.measure(0.01 * k).truth, 14, 9), part(world.start(), 14, 9));
    ASSERT_TRUE(test::apply(world, 0.01 * k, {}, fleet_input, 0.01, 1));
  }
  world.set_presence(std::array{steered, steered, steered, hold});
  EXPECT_EQ(part(world.measure(1.0).truth, 14, 9), part(world.start(), 14, 9));
  // It flies as from the beginning.
  RotorWorld fresh(mixed_fleet(), fleet_start, fleet);
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(test::apply(world, 1.0 + 0.01 * k, {}, fleet_input, 0.01, 1));
    ASSERT_TRUE(test::apply(fresh, 0.01 * k, {}, fleet_input, 0.01, 1));
  }
  EXPECT_EQ(part(world.measure(1.5).truth, 14, 9), part(fresh.measure(0.5).truth, 14, 9));
}

TEST(RotorWorld, AFastTouchOfTheGroundEndsItWithASentence) {
  Team team;
  team.add(VelocityMultirotor{}, {.name = "uav"});
  RotorWorld world(std::move(team), {0, 0, 2, 1, 0, 0, 0, 0, 0}, {{BodyId{0}, Vehicle::x500(), ""}});
  const Numbers down = {0, 0, -1, 0};
  double t = 0.0;
  while (test::apply(world, t, {}, down, 0.01, 1)) {
    ASSERT_EQ(world.ended(), "");
    ASSERT_LT(t += 0.01, 5.0);
  }
  EXPECT_THAT(world.ended(), HasSubstr("uav touched the ground at 2."));
  EXPECT_THAT(world.ended(), HasSubstr(" m/s, expected at most 0.5 m/s"));
}

TEST(RotorWorld, ATouchOfTwoBodiesEndsItWhenTheyHaveBeenApart) {
  const auto ended = [](double gap, bool vehicle) {
    Team team;
    team.add(VelocityMultirotor{}, {.name = "uav"});
    if (vehicle) {
      team.add(Multirotor{}, {.name = "other"});
    } else {
      team.add(Obstacle{.name = "other"});
    }
    Numbers x = {0, 0, 2, 1, 0, 0, 0, 0, 0, gap, 0, 2};
    const Numbers rest = vehicle ? Numbers{1, 0, 0, 0} : Numbers{0, 0, 0};
    x.insert(x.end(), rest.begin(), rest.end());
    std::vector<RobotVehicle> vehicles = {{BodyId{0}, Vehicle::x500(), ""}};
    if (vehicle) vehicles.push_back({BodyId{1}, Vehicle::x500(), ""});
    RotorWorld world(std::move(team), x, vehicles);
    Numbers forward = {1, 0, 0, 0};
    if (vehicle) forward.resize(8);
    for (int k = 0; k < 300; ++k) {
      if (!test::apply(world, 0.01 * k, {}, forward, 0.01, 1)) return world.ended();
    }
    return std::string("flew on");
  };
  EXPECT_THAT(ended(1.5, true), HasSubstr("uav and other touched at"));
  EXPECT_THAT(ended(1.0, false), HasSubstr("uav and other touched at"));
  EXPECT_EQ(ended(20.0, true), "flew on");
  EXPECT_EQ(ended(-20.0, false), "flew on");
  EXPECT_EQ(ended(-0.3, false), "flew on") << "it overlaps at the start, and leaves";
}

TEST(RotorWorld, AStateThatIsNoLongerFiniteEndsItWithoutASentence) {
  RotorWorld world(mixed_fleet(), fleet_start, fleet);
  Numbers spoilt = fleet_input;
  spoilt[4] = std::numeric_limits<double>::max();  // of the rover
  EXPECT_FALSE(test::apply(world, 0.0, {}, spoilt, 0.01, 1));
  EXPECT_EQ(world.ended(), "");
}

TEST(RotorWorld, RefusesWhatItCannotFly) {
  const auto refused = [](const std::vector<RobotVehicle>& vehicles, const PlantOptions& plant) {
    return refusal_of([&] { RotorWorld(mixed_fleet(), fleet_start, vehicles, plant); });
  };
  EXPECT_EQ(refused(fleet, {}), "");
  EXPECT_EQ(refused(fleet, {.period = 0.002}), "");
  RobotVehicle smooth = fleet[0];
  smooth.vehicle.rotor_drag = 0;
  EXPECT_EQ(refused({smooth}, {}), "");
  EXPECT_THAT(refused({smooth}, {.disturbances = {.wind = {0, 1, 0}}}), HasSubstr("vehicle.drag of uav"));
  EXPECT_THAT(refused({smooth}, {.disturbances = {.gust_sigma = 0.1}}), HasSubstr("expected one that wind"));
  smooth.vehicle.drag.z = 0;
  EXPECT_THAT(refused({smooth}, {.downwash = {1.0}}), HasSubstr("wakes and downwash can push"));
  EXPECT_THAT(refusal_of([] { ModelWorld(mixed_fleet(), fleet_start, {.downwash = {1.0}}); }),
              HasSubstr("downwash = 1, expected 0 where no vehicles move"));
}

const PlantOptions blowing = {.downwash = {1.0}};

/// Vehicles of that kind that hover at these places under velocity commands.
struct Hover {
  Team team;
  Numbers x0;
  std::vector<RobotVehicle> vehicles;

  Hover(const Vehicle& vehicle, const std::vector<Vec3<double>>& places) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vec3<double>& p = places[i];
      const AgentId robot = team.add(VelocityMultirotor{}, {.name = "uav" + std::to_string(i)});
      x0.insert(x0.end(), {p.x, p.y, p.z, 1, 0, 0, 0, 0, 0});
      vehicles.push_back({robot, vehicle});
    }
  }
  RotorWorld world(const PlantOptions& plant = blowing) const { return {team, x0, vehicles, plant}; }
  Numbers rest() const { return Numbers(4 * vehicles.size()); }
};
const RigidBody& body_of(const RotorWorld& world, int robot) {
  return world.rotorcraft(BodyId{robot})->body();
}

TEST(RotorWorld, AVehicleAbovePushesTheOneBelowDownWhichHoldsAgainstIt) {
  for (const auto& preset : Vehicle::presets()) {
    const Hover pair(preset.part, {{0, 0, 5}, {0, 0, 6.5}});
    RotorWorld world = pair.world(), still = pair.world({});
    const RigidBody &below = body_of(world, 0), &above = body_of(world, 1);
    double lowest = 5.0, fastest = 0.0;
    for (int k = 0; k < 1500; ++k) {
      ASSERT_TRUE(test::apply(world, 0.01 * k, {}, pair.rest(), 0.01, 1)) << world.ended();
      lowest = std::min(lowest, below.p.z), fastest = std::min(fastest, below.v.z);
    }
    fly(still, 1500, pair.rest());
    EXPECT_LT(lowest, 5.0 - 1e-3) << preset.name;
    EXPECT_LT(fastest, -1e-2) << preset.name;
    EXPECT_NEAR(below.v.z, 0.0, 0.02) << preset.name << ": its climb controller holds it";
    // Thrust makes up for the drag of the air from above.
    const Rotorcraft& craft = *world.rotorcraft(BodyId{0});
    const Jet jet = {
        .p = above.p, .thrust = preset.part.weight(), .radius2 = 4 * square(preset.part.rotor_radius)};
    const double push = -preset.part.drag.z * jet.air(below.p).z;
    EXPECT_GT(push, 0.01 * preset.part.weight()) << preset.name;
    EXPECT_NEAR(craft.lift(), preset.part.weight() + push, 0.02 * push) << preset.name;
    EXPECT_EQ(norm(above.p - body_of(still, 1).p), 0.0) << "who is above feels nothing";
    EXPECT_NEAR(norm(below.p.x, below.p.y), 0.0, 1e-9) << "right below it stays there";
  }
}

TEST(RotorWorld, BeforeItsControllerActsTheLowerVehicleSinksByTheDragOfTheAirTimesTheScale) {
  for (const double scale : {0.4, 0.85}) {
    const Vehicle vehicle = Vehicle::crazyflie();
    const Hover pair(vehicle, {{0, 0, 5}, {0.03, 0, 5.3}});
    RotorWorld world = pair.world({.downwash = {scale}}), still = pair.world({});
    const Jet jet = {
        .p = {0.03, 0, 5.3}, .thrust = vehicle.weight(), .radius2 = 4 * square(vehicle.rotor_radius)};
    const double a = scale * vehicle.drag.z * jet.air({0, 0, 5}).z / vehicle.mass;
    fly(world, 2, pair.rest()), fly(still, 2, pair.rest());
    EXPECT_LT(a, -0.9);
    EXPECT_NEAR(body_of(world, 0).v.z - body_of(still, 0).v.z, 0.02 * a, 0.05 * 0.02 * -a) << scale;
    EXPECT_NEAR(body_of(world, 0).p.z - body_of(still, 0).p.z, 0.5 * 0.02 * 0.02 * a,
                0.08 * 0.5 * 0.02 * 0.02 * -a);
  }
}

TEST(RotorWorld, DownwashFromBothSidesPushesStraightDown) {
  const Hover three(Vehicle::x500(), {{0, 0, 5}, {0.4, 0, 7}, {-0.4, 0, 7}});
  RotorWorld world = three.world();
  fly(world, 300, three.rest());
  EXPECT_LT(body_of(world, 0).p.z, 5.0 - 1e-3);
  EXPECT_NEAR(body_of(world, 0).p.x, 0.0, 1e-9);
  EXPECT_NEAR(body_of(world, 1).p.x, -body_of(world, 2).p.x, 1e-9);
}

TEST(RotorWorld, VehiclesAndTheirDownwashAreTheSameWhateverTheThreads) {
  std::vector<Vec3<double>> places;
  for (int i = 0; i < PlantOptions::vehicles_shared_from + 2; ++i)
    places.push_back({0.6 * (i % 3), 0.6 * (i / 3), 3.0 + i});
  const Hover many(Vehicle::crazyflie(), places);
  const auto flown = [&](int threads) {
    PlantOptions options = blowing;
    if (threads > 1) options.pool = std::make_shared<ThreadPool>(threads);
    RotorWorld world = many.world(options);
    return fly(world, 100, many.rest());
  };
  const Numbers alone = flown(1);
  for (const int threads : {2, 4}) EXPECT_EQ(flown(threads), alone) << threads << " threads";
}

TEST(RotorWorld, FarAsideAtOneHeightAndWithoutDownwashVehiclesFlyAsAloneBitForBit) {
  for (const auto& [other, plant] : {std::pair{Vec3<double>{9, 0, 6}, blowing},
                                     {{1.5, 0, 5}, blowing},
                                     {{0, 0, 7}, PlantOptions{}},
                                     {{0, 0, 7}, PlantOptions{.downwash = {0.0}}}}) {
    const Hover pair(Vehicle::x500(), {{0, 0, 5}, other}), one(Vehicle::x500(), {{0, 0, 5}});
    RotorWorld world = pair.world(plant), alone = one.world();
    fly(world, 100, pair.rest());
    fly(alone, 100, one.rest());
    EXPECT_EQ(norm(body_of(world, 0).p - body_of(alone, 0).p), 0.0);
  }
}

TEST(RotorWorld, WhoIsNotThereYetPushesNoAirAndWhoComesDoes) {
  const Hover pair(Vehicle::x500(), {{0, 0, 5}, {0, 0, 7}}), one(Vehicle::x500(), {{0, 0, 5}});
  RotorWorld world = pair.world(), alone = one.world();
  using enum Presence;
  world.set_presence(std::array{steered, absent});
  fly(world, 100, pair.rest());
  fly(alone, 100, one.rest());
  EXPECT_EQ(norm(body_of(world, 0).p - body_of(alone, 0).p), 0.0);
  world.set_presence(std::array{steered, steered});
  for (int k = 100; k < 200; ++k) ASSERT_TRUE(test::apply(world, 0.01 * k, {}, pair.rest(), 0.01, 1));
  EXPECT_LT(body_of(world, 0).p.z, body_of(alone, 0).p.z - 1e-3);
}

TEST(RotorWorld, WhatAVehicleMeasuresItselfHasTheErrorsOfItsImuAndTheTruthHasNone) {
  Team team;
  team.add(LaggingHoverMultirotor{}, {.name = "uav"});
  Vehicle vehicle = Vehicle::x500();
  vehicle.imu = Imu{};
  RotorWorld world(team, {0, 0, 3, 0.6, 0.8, 0, 0, 0, 0, 0, 0}, {{BodyId{0}, vehicle}});
  for (int k = 0; k < 200; ++k) {
    const Measured now = world.measure(0.01 * k);
    const RigidBody& body = world.rotorcraft(BodyId{0})->body();
    EXPECT_EQ(part(now.measured, 0, 7), part(now.truth, 0, 7));
    EXPECT_EQ(now.truth[10], heading_rate(rotation(body.q), body.w));
    const RigidBody seen = world.rotorcraft(BodyId{0})->seen();
    EXPECT_EQ(now.measured[10], heading_rate(rotation(seen.q), seen.w));
    for (const std::size_t i : {7U, 8U, 10U}) {
      EXPECT_NE(now.measured[i], now.truth[i]);
      EXPECT_NEAR(now.measured[i], now.truth[i], 0.4);
    }
    ASSERT_TRUE(test::apply(world, 0.01 * k, {}, Numbers{0.3, 0.1, 0, 0.2}, 0.01, 1));
  }
}

}  // namespace
}  // namespace sightline
