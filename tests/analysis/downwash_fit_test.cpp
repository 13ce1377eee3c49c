#include "sightline/analysis/identification/downwash_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sightline/robots.hpp"
#include "sightline/scenario.hpp"
#include "sightline/world/rotorcraft.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/shared_data.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

constexpr double scale = 0.8, thrust_lag = 0.06;

/// Two small vehicles. The upper one moves on a Lissajous figure around the place above the other.
/// The lower one's thrust holds its height, and the air pushes it by `pushed`.
/// @param sigma  of the measured acceleration [m/s^2]
/// @param lag    of the thrust [s]
DownwashFlight crossing(Random& random, double sigma, double pushed = scale, double lag = thrust_lag,
                        double seconds = 30.0) {
  const Vehicle vehicle = Vehicle::crazyflie();
  RotorRecord upper{.name = "upper", .vehicle = vehicle}, lower{.name = "lower", .vehicle = vehicle};
  std::normal_distribution<double> noise(0.0, sigma);
  constexpr double step = 0.001, c = 30.0;
  const double drag = vehicle.drag.z / vehicle.mass, phase = uniform(random, 0.0, 1.0);
  double z = 0.5, v_z = 0.0, thrust = gravity / c;
  for (int i = 0; step * i < seconds; ++i) {
    const double t = step * i, a = 1.1 * t + phase, b = 1.7 * t + 2 * phase;
    const Vec3<double> p = {0.4 * std::sin(a), 0.2 * std::sin(b), 0.9};
    const Vec3<double> v = {0.44 * std::cos(a), 0.34 * std::cos(b), 0.0};
    const Jet jet{.p = p,
                  .thrust = vehicle.weight(),
                  .radius2 = static_cast<double>(vehicle.rotors()) * square(vehicle.rotor_radius),
                  .v = v};
    const double power = (gravity + 20 * (0.5 - z) - 6 * v_z) / c;
    const double a_z = c * thrust + drag * (pushed * jet.air({0, 0, z}).z - v_z);
    if (i % 10 == 0) {
      for (RotorRecord* const one : {&upper, &lower}) {
        const bool below = one == &lower;
        one->t.push_back(t);
        one->p.push_back(below ? Vec3<double>{0, 0, z} : p);
        one->v.push_back(below ? Vec3<double>{0, 0, v_z} : v);
        one->up.push_back({0, 0, 1});
        one->a_z.push_back((below ? a_z : gravity) + noise(random));
        one->power.push_back(below ? power : gravity / c);
      }
    }
    thrust += step / lag * (power - thrust);
    v_z += step * (a_z - gravity);
    z += step * v_z;
  }
  return {upper, lower};
}

TEST(DownwashFit, FindsTheScaleAndTheLagOfAFlightWithoutNoise) {
  Random random(1);
  const DownwashIdentification found = identify_downwash({crossing(random, 0.0)});
  EXPECT_NEAR(found.scale, scale, 0.01);
  EXPECT_NEAR(found.lag, thrust_lag, 0.0051);
  EXPECT_NEAR(found.seconds, 30.0, 0.1);
  ASSERT_EQ(found.errors.size(), 1u) << "who is above feels nothing";
  EXPECT_EQ(found.errors[0].robot, "lower");
  EXPECT_LT(found.errors[0].all.ratio(), 0.1);
}

TEST(DownwashFit, UnderNoiseTheIntervalsHoldTheScaleAndTheErrors) {
  int held = 0;
  double covered = 0.0, inside = 0.0;
  constexpr int flights = 12;
  for (int seed = 1; seed <= flights; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const DownwashIdentification found = identify_downwash({crossing(random, 0.3)});
    held += found.low() <= scale && scale <= found.high() ? 1 : 0;
    covered += found.errors[0].all.covered / flights, inside += found.errors[0].inside.covered / flights;
    EXPECT_LT(found.interval, 0.1 * scale);
    EXPECT_NEAR(found.errors[0].all.with, 0.3, 0.02) << "the noise is left";
  }
  EXPECT_GE(held, 10) << "of 12, 95 % are expected";
  EXPECT_NEAR(covered, 0.95, 0.02);
  EXPECT_NEAR(inside, 0.95, 0.02);
}

TEST(DownwashFit, OfTheWorldOfRotorsItIsTheScaleOfThatWorld) {
  Team team;
  Vehicle vehicle = Vehicle::crazyflie();
  std::vector<RobotVehicle> vehicles;
  for (const char* const name : {"lower", "upper"})
    vehicles.push_back({team.add(VelocityMultirotor{}, {.name = name}), vehicle});
  const std::vector<double> x0 = {0, 0, 2, 1, 0, 0, 0, 0, 0, /**/ -0.5, 0, 2.6, 1, 0, 0, 0, 0, 0};
  RotorWorld world(team, x0, vehicles, {.downwash = {scale}});
  DownwashFlight flight = {{.name = "lower", .vehicle = vehicle}, {.name = "upper", .vehicle = vehicle}};
  for (int k = 0; k < 2000; ++k) {
    const double t = 0.01 * k;
    for (int i = 0; i < 2; ++i) {
      const Rotorcraft& craft = *world.rotorcraft(BodyId{i});
      RotorRecord& record = flight[static_cast<std::size_t>(i)];
      record.t.push_back(t), record.p.push_back(craft.body().p), record.v.push_back(craft.body().v);
      record.up.push_back(craft.attitude().z), record.power.push_back(craft.lift());
      if (k > 0) record.a_z.push_back(gravity + (record.v[at(k)].z - record.v[at(k - 1)].z) / 0.01);
    }
    // To and fro above the lower one.
    const double forward = std::cos(0.8 * t) > 0 ? 0.3 : -0.3;
    ASSERT_TRUE(test::apply(world, t, {}, std::vector<double>{0, 0, 0, 0, forward, 0, 0, 0}, 0.01, 1));
  }
  for (RotorRecord& one : flight) one.a_z.push_back(one.a_z.back());
  const DownwashIdentification found = identify_downwash({flight});
  EXPECT_NEAR(found.scale, scale, 0.03 * scale);
  EXPECT_LT(found.errors.at(0).all.ratio(), 0.15);
}

TEST(DownwashFit, SeveralFlightsJudgeEachOtherAndHeldOutOnesJudgeAlone) {
  Random random(3);
  const DownwashFlight one = crossing(random, 0.1), two = crossing(random, 0.1);
  const DownwashIdentification each = identify_downwash({one, two});
  ASSERT_EQ(each.errors.size(), 2u);
  EXPECT_EQ(each.errors[1].flight, 1);
  EXPECT_EQ(each.judged_on, "each flight by the others");
  const DownwashIdentification alone = identify_downwash({one}, {two});
  ASSERT_EQ(alone.errors.size(), 1u);
  EXPECT_EQ(alone.judged_on, "held-out flights");
  EXPECT_EQ(alone.scale, identify_downwash({one}).scale) << "who judges does not teach";
  EXPECT_NEAR(alone.errors[0].all.with, each.errors[1].all.with, 1e-3);
}

TEST(DownwashFit, TheBoundGrowsWithTheDownwashAndIsTheCalmOneWithoutIt) {
  const DownwashBound bound{.calm = 0.3, .gusty = 0.7};
  EXPECT_EQ(bound.at(0), 0.3);
  EXPECT_NEAR(bound.at(1), std::hypot(0.3, 0.7), 1e-15);
  for (double d = 0; d < 10; d += 0.1) {
    EXPECT_LT(bound.at(d), bound.at(d + 0.1));
    EXPECT_EQ(bound.at(d), bound.at(-d));
  }
}

TEST(DownwashFit, RefusesFlightsThatShowNoDownwash) {
  Random random(4);
  EXPECT_THAT(refusal_of([&] { identify_downwash({crossing(random, 0.1, 0.0)}); }),
              HasSubstr("expected one above 0"));
  EXPECT_THAT(refusal_of([&] { identify_downwash({crossing(random, 0.1, 2.5)}); }),
              HasSubstr("expected 0 to 2; check mass, rotors and drag of the vehicles"));
  DownwashFlight aside = crossing(random, 0.1);
  for (Vec3<double>& p : aside[0].p) p.x += 5.0;
  EXPECT_THAT(refusal_of([&] { identify_downwash({aside}); }), HasSubstr("no vehicle is in the downwash"));
  DownwashFlight once = crossing(random, 0.1);
  for (std::size_t k = 0; k < once[0].t.size(); ++k) {
    const bool above = once[0].t[k] > 8 && once[0].t[k] < 10;
    once[0].p[k] = {above ? 0.0 : 5.0, 0, 0.9}, once[0].v[k] = {0, 0, 0};
  }
  EXPECT_THAT(
      refusal_of([&] { identify_downwash({once}); }),
      "without fifth 2 of the flight, vehicles were in the downwash for 0 s, expected at least 0.5 s: give "
      "another flight");
  EXPECT_THAT(refusal_of([&] {
                identify_downwash({crossing(random, 0.1), aside});
              }),
              HasSubstr("without flight 0, vehicles were in the downwash for 0 s"));
  EXPECT_THAT(refusal_of([&] { identify_downwash({crossing(random, 0.1)}, {aside}); }),
              HasSubstr("no vehicle is in the downwash"));
  EXPECT_THAT(
      refusal_of([&] {
        identify_downwash({crossing(random, 0.05, scale, thrust_lag, 90.0), crossing(random, 0.05, -0.1)});
      }),
      HasSubstr("without flight 0, the downwash is -0.1"));
  DownwashFlight another_time = crossing(random, 0.1);
  for (double& t : another_time[0].t) t += 100.0;
  EXPECT_THAT(refusal_of([&] { identify_downwash({another_time}); }), HasSubstr("of one clock"));
  DownwashFlight never_calm = crossing(random, 0.1);
  for (Vec3<double>& p : never_calm[0].p) p = {0, 0, 0.9};
  EXPECT_THAT(refusal_of([&] { identify_downwash({crossing(random, 0.1)}, {never_calm}); }),
              HasSubstr("lower was outside of the downwash for 0 s, expected at least 2 s"));
}

/// The flight with one more vehicle. It cuts its motors 0.05 s before it is under the upper one.
/// Only with a lag of its thrust above 0.15 s would it still fly there.
DownwashFlight with_one_that_lands(const DownwashFlight& flight) {
  const RotorRecord& upper = flight[0];
  RotorRecord lands = upper;
  lands.name = "lands";
  std::size_t under = 1000;
  while (std::hypot(upper.p[under].x - 0.35, upper.p[under].y) > 0.05) ++under;
  for (std::size_t k = 0; k < lands.t.size(); ++k) {
    lands.p[k] = {k < under ? 5.0 : 0.35, 0, 0.5};
    lands.v[k] = {0, 0, 0};
    if (k + 5 >= under) lands.power[k] = lands.a_z[k] = 0.0;
  }
  return {upper, lands, flight[1]};
}

TEST(DownwashFit, WhoCutsItsMotorsBeforeAPassDoesNotCountAtAnyLag) {
  Random random(6);
  const DownwashFlight fast = crossing(random, 0.05, scale, 0.03), slow = crossing(random, 0.05, scale, 0.25);
  const DownwashIdentification two = identify_downwash({fast, slow}),
                               three = identify_downwash({with_one_that_lands(fast), slow});
  EXPECT_DOUBLE_EQ(three.scale, two.scale);
  ASSERT_EQ(three.errors.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(three.errors[i].robot, "lower");
    EXPECT_EQ(three.errors[i].flight, static_cast<int>(i));
    EXPECT_EQ(three.errors[i].all.samples, two.errors[i].all.samples);
    EXPECT_DOUBLE_EQ(three.errors[i].all.with, two.errors[i].all.with);
  }
}

TEST(DownwashFit, TableAndJsonSayTheSameAndTheKeysAreThoseOfAScenario) {
  Random random(5);
  const DownwashIdentification found = identify_downwash({crossing(random, 0.1)});
  const nlohmann::json json = nlohmann::json::parse(to_json(found));
  EXPECT_EQ(json.at("downwash"), found.scale);
  EXPECT_EQ(json.at("errors").at(0).at("inside").at("with_rms"), found.errors[0].inside.with);
  const std::string keys = json.at("template");
  EXPECT_THAT(to_string(found), HasSubstr(keys));
  const Scenario scenario = parse_scenario(
      "[agent.uav]\nrobot = \"multirotor\"\nstart = { p = [0.0, 0.0, 3.0], heading = 0.0 }\n"
      "Q = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]\nR = [1.0, 1.0, 1.0, 1.0]\n" +
          keys,
      "a.toml");
  EXPECT_NEAR(scenario.downwash.scale, found.scale, 1e-3);
}

constexpr std::string_view rotor_table =
    "t_ms,x,y,z,vx,vy,vz,az,qx,qy,qz,qw,pwm1,pwm2,battery\n"
    "0,1,2,3,4,5,6,9.8,0,0,0,1,0.5,0.7,4.0\n"
    "10,1,2,3,4,5,6,9.9,0.6,0,0,0.8,0.5,0.7,4.0\n";

TEST(DownwashFlight, ReadsARecordFromATable) {
  const RotorRecord record = rotor_record(read_csv(rotor_table, "a.csv"), "cf1", Vehicle::crazyflie());
  EXPECT_EQ(record.t, (std::vector<double>{0.0, 0.01}));
  EXPECT_EQ(record.p[1].z, 3.0);
  EXPECT_EQ(record.v[1].x, 4.0);
  EXPECT_EQ(record.a_z[1], 9.9);
  EXPECT_NEAR(record.power[0], 16.0 * 0.5 * (0.25 + 0.49), 1e-12);
  EXPECT_EQ(record.up[0].z, 1.0);
  EXPECT_NEAR(record.up[1].z, std::cos(2 * std::asin(0.6)), 1e-12) << "it rolls to the right";
  EXPECT_NEAR(record.up[1].y, -std::sin(2 * std::asin(0.6)), 1e-12);
}

TEST(DownwashFlight, RefusesTablesThatLackSomething) {
  const auto refused = [](std::string_view from, const std::string& to) {
    std::string text(rotor_table);
    text.replace(text.find(from), from.size(), to);
    return refusal_of([&] { rotor_record(read_csv(text, "a.csv"), "cf1", Vehicle::crazyflie()); });
  };
  EXPECT_THAT(refused("t_ms", "stamp"), HasSubstr("no column \"t\", expected the columns t (or t_ms, t_us)"));
  EXPECT_THAT(refused("pwm1", "m1"), HasSubstr("no column \"pwm1\""));
  EXPECT_THAT(refused("\n10,", "\n0,"), HasSubstr("t = 0 s in row 2 of numbers after 0 s"));
  EXPECT_THAT(refused("0,0,0,1,0.5", "0,0,0,0,0.5"), HasSubstr("the attitude in row 1"));
  EXPECT_THAT(refusal_of([] { downwash_flight({"a.csv"}, {Vehicle()}, {}); }),
              "1 recording of a flight, expected at least two: FILE,FILE");
  EXPECT_THAT(refusal_of([] {
                downwash_flight({"a.csv", "b.csv"}, {Vehicle(), Vehicle(), Vehicle()}, {});
              }),
              "3 vehicles for 2 recordings of a flight, expected one for all or one for each");
  EXPECT_THAT(refusal_of([] { named_vehicle("x5"); }),
              HasSubstr("vehicle = x5, expected one of x500, crazyflie, ar_drone, or a file"));
}

TEST(DownwashFit, OfRecordedCrazyfliesItHalvesTheErrorAndTheIntervalHolds95Percent) {
  const std::string swap = "neural_swarm/21_06_16_2020__swap_ss__";
  const auto lower = test::of_data(swap + "cf50_00.csv.gz"), upper = test::of_data(swap + "cf51_00.csv.gz");
  if (lower.empty() || upper.empty()) return;
  const DownwashIdentification found = identify_downwash(
      {downwash_flight({lower, upper}, {named_vehicle("crazyflie")},
                       {"t_us", "x",    "y",       "z",  "vx", "vy", "vz", "-", "-",    "az",
                        "qx",   "qy",   "qz",      "qw", "-",  "-",  "-",  "-", "pwm1", "pwm2",
                        "pwm3", "pwm4", "battery", "-",  "-",  "-",  "-",  "-", "-",    "-"})});
  ASSERT_EQ(found.errors.size(), 1u);
  const DownwashErrors& held_out = found.errors[0];
  EXPECT_EQ(held_out.robot, "21_06_16_2020__swap_ss__cf50_00");
  EXPECT_GT(held_out.inside.samples, 150u);
  for (const DownwashError& error : {held_out.all, held_out.inside}) {
    EXPECT_LE(error.ratio(), 0.5);
    EXPECT_GE(error.covered, 0.93);
    EXPECT_LE(error.covered, 0.97);
  }
  EXPECT_LT(found.interval, 0.1 * found.scale);
}

}  // namespace
}  // namespace sightline
