#include "sightline/mujoco.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "cli/allocations.hpp"
#include "sightline/world/rotorcraft.hpp"
#include "tests/mujoco/team.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/error.hpp"
#include "tests/support/hexacopter.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using namespace test;
using testing::StartsWith;

template <class W>
W world_of(const Scene& s, const PlantOptions& plant = {}) {
  return W(s.team, s.x0, s.vehicles, plant);
}
std::vector<Vehicle> all_vehicles() {
  std::vector<Vehicle> all = {hexacopter()};
  for (const auto& preset : Vehicle::presets()) all.push_back(preset.part);
  return all;
}
Numbers copy(std::span<const double> x) { return {x.begin(), x.end()}; }

/// The greatest difference of two lists of one length.
double apart(const Numbers& a, const Numbers& b) {
  EXPECT_EQ(a.size(), b.size());
  const std::size_t both = std::min(a.size(), b.size());
  return largest_difference(std::span(a).first(both), std::span(b).first(both));
}

TEST(Mujoco, WhereNothingTouchesItFliesAsTheWorldOfRotorsTo1e9) {
  const PlantOptions gusty = {
      .disturbances = {.wind = {0.4, -0.2, 0}, .gust_sigma = 0.2, .input_delay = 0.013}};
  for (const Vehicle& v : all_vehicles()) {
    for (const PlantOptions& plant : {PlantOptions{}, gusty}) {
      MujocoWorld mujoco(mixed_fleet(), mixed_start, fleet_of(v, v), plant);
      RotorWorld rotors(mixed_fleet(), mixed_start, fleet_of(v, v), plant);
      const Numbers flown = fly(mujoco, 3000, swinging), expected = fly(rotors, 3000, swinging);
      EXPECT_LT(apart(flown, expected), 1e-9) << "mass " << v.mass << ": " << mujoco.ended();
      EXPECT_GT(norm(mujoco.rotorcraft(BodyId{0})->body().p - Vec3<double>{0, 0, 40}), 0.1) << "it moves";
    }
  }
}

// Right below each other, so that the air of one moves around the other.
TEST(Mujoco, WithDownwashAndTheErrorsOfAnImuItFliesAsTheWorldOfRotorsTo1e9) {
  const PlantOptions plant = {.seed = 5, .disturbances = {.gust_sigma = 0.2}, .downwash = {1.0}};
  const SensorOptions sensor = {.seed = 5, .odometry = {.position_walk = 0.01, .velocity_scale = 0.02}};
  Numbers start = mixed_start;
  start[14] = 0.3, start[15] = 0.0, start[16] = 44.0;
  for (Vehicle v : all_vehicles()) {
    v.imu = Imu{};
    MujocoWorld mujoco(mixed_fleet(), start, fleet_of(v, v), plant, sensor);
    RotorWorld rotors(mixed_fleet(), start, fleet_of(v, v), plant, sensor),
        still(mixed_fleet(), start, fleet_of(v, v), {.seed = 5, .disturbances = plant.disturbances}, sensor);
    const Numbers flown = fly(mujoco, 3000, swinging), expected = fly(rotors, 3000, swinging);
    EXPECT_LT(apart(flown, expected), 1e-9) << "mass " << v.mass << ": " << mujoco.ended();
    EXPECT_GT(apart(expected, fly(still, 3000, swinging)), 1e-3) << "mass " << v.mass;
  }
}

TEST(Mujoco, TheSameSeedGivesTheSameBytesAndAnotherOthers) {
  const auto flown = [](std::uint64_t seed) {
    MujocoWorld world(mixed_fleet(), mixed_start, fleet_of(Vehicle::x500(), Vehicle::crazyflie()),
                      {.seed = seed, .disturbances = {.gust_sigma = 0.2}},
                      {.seed = seed, .noise = {.position = 0.01}, .delay = 0.02});
    return fly(world, 300, swinging);
  };
  const Numbers first = flown(3);
  EXPECT_EQ(first, flown(3));
  EXPECT_NE(first, flown(4));
  // Contacts too.
  const auto landed = [] {
    auto world = world_of<MujocoWorld>(scene(Vehicle::x500(), 0.3));
    return fly(world, 300, [](double) { return Numbers{0.1, 0, -0.2, 0.1}; });
  };
  EXPECT_EQ(landed(), landed());
}

TEST(Mujoco, WhoIsAbsentRestsAndWhoJoinsBeginsAtTheStart) {
  MujocoWorld mujoco(mixed_fleet(), mixed_start, fleet_of(Vehicle::x500(), Vehicle::x500()));
  RotorWorld rotors(mixed_fleet(), mixed_start, fleet_of(Vehicle::x500(), Vehicle::x500()));
  using enum Presence;
  int k = 0;
  for (const auto& presence :
       {std::array{steered, steered, absent, hold}, std::array{steered, absent, steered, absent},
        std::array{absent, steered, steered, hold}, std::array{steered, steered, steered, hold}}) {
    mujoco.set_presence(presence);
    rotors.set_presence(presence);
    EXPECT_LT(apart(fly(mujoco, 100, swinging, k), fly(rotors, 100, swinging, k)), 1e-10);
    k += 100;
  }
}

TEST(Mujoco, PeriodsThatWereMissedPassUnderTheInputsThatWentOn) {
  const auto fleet = fleet_of(Vehicle::x500(), Vehicle::crazyflie());
  MujocoWorld at_once(mixed_fleet(), mixed_start, fleet), one_by_one(mixed_fleet(), mixed_start, fleet);
  ASSERT_TRUE(test::apply(at_once, 0.0, {}, swinging(1.0), 0.01, 25));
  for (int k = 0; k < 25; ++k) ASSERT_TRUE(test::apply(one_by_one, 0.01 * k, {}, swinging(1.0), 0.01, 1));
  EXPECT_EQ(copy(at_once.measure(0.25).truth), copy(one_by_one.measure(0.25).truth));
}

TEST(Mujoco, AFastTouchOfTheGroundEndsItAsInTheWorldOfRotors) {
  for (const Vehicle& v : all_vehicles()) {
    for (const double speed : {0.7, 1.0}) {
      auto mujoco = world_of<MujocoWorld>(scene(v, 1.5));
      auto rotors = world_of<RotorWorld>(scene(v, 1.5));
      const End end = end_of(mujoco, {0, 0, -speed}), expected = end_of(rotors, {0, 0, -speed});
      EXPECT_NEAR(end.t, expected.t, 0.011);
      EXPECT_THAT(expected.why, StartsWith("uav touched the ground at "));
      EXPECT_EQ(end.why.substr(end.why.find("s with")), expected.why.substr(expected.why.find("s with")));
    }
  }
}

TEST(Mujoco, ASlowTouchIsCarriedAndTheVehicleRisesAgain) {
  for (const Vehicle& v : all_vehicles()) {
    auto world = world_of<MujocoWorld>(scene(v, 0.5));
    EXPECT_EQ(end_of(world, {0, 0, -0.3}, 4.0).why, "");
    const RigidBody& body = world.rotorcraft(BodyId{0})->body();
    EXPECT_NEAR(body.p.z, 0.0, 2e-3) << "mass " << v.mass;
    EXPECT_LT(norm(body.v), 0.02);
    EXPECT_GT(world.rotorcraft(BodyId{0})->attitude().z.z, 0.999);
    const Numbers up = {0, 0, 0.5, 0};
    for (int k = 400; k < 900; ++k)
      ASSERT_TRUE(test::apply(world, 0.01 * k, {}, up, 0.01, 1)) << world.ended();
    EXPECT_GT(body.p.z, 1.0);
  }
}

TEST(Mujoco, ATouchOfAnotherBodyEndsItAsInTheWorldOfRotors) {
  for (const Vehicle& v : all_vehicles()) {
    for (const auto& [other, gap] :
         {std::pair{Other::vehicle, 4 * v.radius}, std::pair{Other::post, 3 * v.radius}}) {
      auto mujoco = world_of<MujocoWorld>(scene(v, 3.0, other, gap));
      auto rotors = world_of<RotorWorld>(scene(v, 3.0, other, gap));
      const End end = end_of(mujoco, {1, 0, 0}), expected = end_of(rotors, {1, 0, 0});
      EXPECT_THAT(end.why, StartsWith("uav and other touched at "));
      EXPECT_THAT(expected.why, StartsWith("uav and other touched at "));
      // The cylinder tilts along, so it reaches a little less far.
      EXPECT_NEAR(end.t, expected.t, 0.05) << "mass " << v.mass;
    }
  }
}

TEST(Mujoco, WhoOverlapsAtTheStartTouchesWhenTheyHaveBeenApart) {
  for (const Other other : {Other::vehicle, Other::post}) {
    auto world = world_of<MujocoWorld>(scene(Vehicle::x500(), 3.0, other, -0.3));
    auto alone = world_of<MujocoWorld>(scene(Vehicle::x500(), 3.0));
    EXPECT_EQ(end_of(world, {1, 0, 0}, 3.0).why, "");
    EXPECT_EQ(end_of(alone, {1, 0, 0}, 3.0).why, "");
    EXPECT_EQ(world.rotorcraft(BodyId{0})->body().p.x, alone.rotorcraft(BodyId{0})->body().p.x)
        << "nothing pushes them apart";
    const Numbers back = {-1, 0, 0, 0, 0, 0, 0, 0};
    const auto u = std::span(back).first(static_cast<std::size_t>(world.team().nu()));
    int k = 300;
    while (k < 900 && test::apply(world, 0.01 * k, {}, u, 0.01, 1)) ++k;
    EXPECT_THAT(world.ended(), StartsWith("uav and other touched at "));
  }
}

TEST(Mujoco, WhoIsAbsentTouchesNobodyAndWhoJoinsWithinAnotherIsExcused) {
  auto world = world_of<MujocoWorld>(scene(Vehicle::x500(), 3.0, Other::post, 0.9));
  using enum Presence;
  world.set_presence(std::array{steered, absent});
  EXPECT_EQ(end_of(world, {0.5, 0, 0}, 2.2).why, "") << "it is where the other would be";
  world.set_presence(std::array{steered, hold});
  const Numbers on = {0.5, 0, 0, 0};
  for (int k = 220; k < 500; ++k) ASSERT_TRUE(test::apply(world, 0.01 * k, {}, on, 0.01, 1)) << world.ended();
}

TEST(Mujoco, AMovingTargetTouchesWhereItIsByThen) {
  Scene s = scene(Vehicle::x500(), 3.0, Other::post, 4.0);
  s.x0[12] = -2.0;  // v_x
  auto world = world_of<MujocoWorld>(s);
  const End end = end_of(world, {0, 0, 0});
  EXPECT_THAT(end.why, StartsWith("uav and other touched at "));
  EXPECT_NEAR(std::stod(end.why.substr(24)), (4.0 - Vehicle::x500().radius) / 2.0, 2e-3);
}

TEST(Mujoco, ATeamWithoutVehiclesMovesAsInTheModelWorld) {
  MujocoWorld mujoco(mixed_fleet(), mixed_start, {});
  ModelWorld models(mixed_fleet(), mixed_start);
  EXPECT_EQ(fly(mujoco, 50, swinging), fly(models, 50, swinging));
}

TEST(Mujoco, AStateThatIsNoLongerFiniteEndsIt) {
  MujocoWorld world(mixed_fleet(), mixed_start, fleet_of(Vehicle::x500(), Vehicle::crazyflie()));
  Numbers spoilt = swinging(0.0);
  spoilt[4] = std::numeric_limits<double>::max();  // of the rover
  EXPECT_FALSE(test::apply(world, 0.0, {}, spoilt, 0.01, 1));
}

TEST(Mujoco, AFlightAllocatesNothing) {
  if (!cli::counts_allocations()) return;
  MujocoWorld world(mixed_fleet(), mixed_start, fleet_of(Vehicle::x500(), Vehicle::crazyflie()));
  auto landing = world_of<MujocoWorld>(scene(Vehicle::x500(), 0.2, Other::vehicle, 0.1));
  const Numbers u = swinging(0.3), down = {0, 0, -0.2, 0, 0, 0, -0.2, 0};
  test::AnyCommand swings(world.team()), lands(landing.team());
  const std::int64_t before = cli::allocations();
  for (int k = 0; k < 300; ++k) {
    world.apply(0.01 * k, {}, swings(u), 0.01, 1);
    landing.apply(0.01 * k, {}, lands(down), 0.01, 1);
  }
  EXPECT_EQ(cli::allocations(), before);
}

TEST(Mujoco, RefusesWhatTheWorldOfRotorsRefuses) {
  const auto refused = [](const auto& vehicles, const PlantOptions& plant, double z) {
    Numbers x = mixed_start;
    x[2] = z;
    std::string said = refusal_of([&] { MujocoWorld(mixed_fleet(), x, vehicles, plant); });
    std::string as = refusal_of([&] { RotorWorld(mixed_fleet(), x, vehicles, plant); });
    if (const auto at = as.find("\"rotors\""); at != std::string::npos) as.replace(at, 8, "\"mujoco\"");
    EXPECT_EQ(said, as);
    return said;
  };
  const auto fleet = fleet_of(Vehicle::x500(), Vehicle::crazyflie());
  Vehicle smooth = Vehicle::x500();
  smooth.rotor_drag = 0;
  EXPECT_EQ(refused(fleet, {}, 2.0), "");
  EXPECT_EQ(refused(fleet, {}, 0.0), "");
  EXPECT_NE(refused(fleet, {}, -0.1), "");
  EXPECT_NE(refused(fleet, {.period = 0.0125}, 2.0), "");
  EXPECT_NE(refused(std::vector<RobotVehicle>{{BodyId{1}, Vehicle::x500()}}, {}, 2.0), "");
  EXPECT_NE(refused(std::vector<RobotVehicle>{fleet[0], fleet[0]}, {}, 2.0), "");
  EXPECT_NE(refused(fleet_of(smooth, smooth), {.disturbances = {.wind = {1, 0, 0}}}, 2.0), "");
}

}  // namespace
}  // namespace sightline
