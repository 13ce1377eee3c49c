#include "sightline/scenario/read_vehicle.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "sightline/base.hpp"
#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/sample_sink.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::scenario_of;
using test::scenario_refusal;
using testing::HasSubstr;
using testing::Not;

const std::string two = R"toml([world]
kind = "rotors"

[agent.uav]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0 }

[agent.rover]
robot = "omni_rover"
start = { p = [3.0, 0.0, 0.0], heading = 0.0 }
)toml";

std::string uav(const std::string& lines) { return two + "\n[agent.uav.vehicle]\n" + lines; }

TEST(ReadVehicle, AMultirotorIsAnX500WhereNothingIsSaidAndARoverNone) {
  const Scenario scenario = scenario_of(two);
  ASSERT_EQ(scenario.vehicles.size(), 1u);
  EXPECT_EQ(scenario.vehicles[0].robot, scenario.team.find("uav"));
  EXPECT_EQ(scenario.vehicles[0].preset, "x500");
  EXPECT_EQ(scenario.vehicles[0].vehicle.mass, Vehicle::x500().mass);
  EXPECT_THAT(summary(scenario), HasSubstr("world       rotors\n"));
  EXPECT_THAT(summary(scenario),
              HasSubstr("vehicle     uav: x500, 2.06 kg, 4 rotors, thrust to weight 1.69\n"));
  EXPECT_THAT(summary(scenario), Not(HasSubstr("wind")));
}

TEST(ReadVehicle, APointMassIsAVehicleWhereItHasATableAndElseAPoint) {
  std::string point = two;
  point.replace(point.find("multirotor"), std::string("multirotor").size(), "point_mass");
  EXPECT_TRUE(scenario_of(point).vehicles.empty());
  const Scenario scenario = scenario_of(point + "\n[agent.uav.vehicle]\npreset = \"crazyflie\"\n");
  ASSERT_EQ(scenario.vehicles.size(), 1u);
  EXPECT_EQ(scenario.vehicles[0].preset, "crazyflie");
}

TEST(ReadVehicle, APresetIsTheStartForTheNumbersThatAreGiven) {
  const Vehicle v =
      scenario_of(uav("preset = \"crazyflie\"\nmass = 0.035\ntilt_max = 0.3\ndrag = [0.01, 0.02, 0.03]\n"))
          .vehicles[0]
          .vehicle;
  EXPECT_EQ(v.mass, 0.035);
  EXPECT_EQ(v.tilt_max, 0.3);
  EXPECT_EQ(v.drag.y, 0.02);
  EXPECT_EQ(v.k_f, Vehicle::crazyflie().k_f);
  EXPECT_EQ(v.attitude_gain, Vehicle::crazyflie().attitude_gain);
}

TEST(ReadVehicle, SixRotorsAreWrittenOut) {
  const Vehicle v = scenario_of(uav("rotor_x = [0.0, 0.0, 0.26, -0.26, 0.26, -0.26]\n"
                                    "rotor_y = [-0.3, 0.3, 0.15, -0.15, -0.15, 0.15]\n"
                                    "spin = [-1, 1, -1, 1, 1, -1]\n"))
                        .vehicles[0]
                        .vehicle;
  EXPECT_EQ(v.rotors(), 6u);
}

TEST(ReadVehicle, AnImuHasErrorsWhereItIsGivenByItsPresetAndByNumbers) {
  const auto imu = [](const std::string& line) { return scenario_of(uav(line)).vehicles[0].vehicle.imu; };
  EXPECT_FALSE(imu("mass = 2.1\n").has_value());
  EXPECT_EQ(imu("imu = {}\n").value().gyro_noise, Imu::bmi088().gyro_noise);
  const Imu other = imu("imu = { preset = \"icm20689\", gyro_bias = 0.01 }\n").value();
  EXPECT_EQ(other.accelerometer_noise, Imu::icm20689().accelerometer_noise);
  EXPECT_EQ(other.gyro_bias, 0.01);
  EXPECT_THAT(summary(scenario_of(uav("imu = {}\n"))),
              HasSubstr("thrust to weight 1.69, an IMU with errors\n"));
}

TEST(ReadVehicle, DownwashIsANumberOfAWorldOfVehicles) {
  std::string text = two;
  text.replace(text.find("kind = \"rotors\""), 15, "kind = \"rotors\"\ndownwash = 1");
  const Scenario scenario = scenario_of(text);
  EXPECT_EQ(scenario.downwash.scale, 1.0);
  EXPECT_EQ(plant_options(scenario).downwash.scale, 1.0);
  EXPECT_THAT(summary(scenario), HasSubstr("world       rotors, downwash 1\n"));
  EXPECT_EQ(scenario_of(two).downwash.scale, 0.0);
  text.replace(text.find("\"rotors\""), 8, "\"model\"");
  EXPECT_EQ(
      scenario_refusal(text),
      "a.toml:3: world.downwash = 1, expected no such key in the world \"model\", only with world.kind = "
      "\"rotors\"");
}

TEST(ReadVehicle, AWorldOfOnesOwnIsGivenTheVehiclesWhereItSaysThatItHasThem) {
  Registry registry;
  const MakeWorld make = registry.worlds.find("rotors")->make;
  registry.worlds.add("arena", make, MovedBy::vehicles).add("basin", registry.worlds.find("model")->make);
  EXPECT_EQ(registry.worlds.names(&WorldPart::has_vehicles),
            (std::vector<std::string_view>{"rotors", "arena"}));
  const auto vehicles_in = [&](const std::string& world) {
    std::string text = two;
    text.replace(text.find("rotors"), 6, world);
    return parse_scenario(text, "a.toml", registry).vehicles.size();
  };
  EXPECT_EQ(vehicles_in("arena"), 1u);
  EXPECT_EQ(vehicles_in("basin"), 0u);
}

TEST(ReadVehicle, AWorldThatReadsModelFilesIsGivenTheirTextsAndSaysMassAndInertia) {
  const auto folder = test::fresh_folder();
  std::filesystem::create_directories(folder / "models");
  std::ofstream(folder / "models/quad.txt") << "1.25";
  const auto weighed = [](const Vehicle& vehicle, const ModelBody& model) {
    if (model.body != "hull") throw_invalid("body = \"{}\", expected \"hull\"", model.body);
    Vehicle read = vehicle;
    read.mass = std::stod(model.file.text);
    read.inertia = {0.01, 0.02, 0.025};
    read.k_f = 1.0;
    return read;
  };
  Registry registry;
  const auto never = [](const Scenario&) -> std::unique_ptr<World> {
    ADD_FAILURE() << "reading makes no world";
    return nullptr;
  };
  registry.worlds.add("arena", never, MovedBy::vehicles, weighed);
  const auto read_in_arena = [&](const std::string& world, const std::string& vehicle,
                                 const ScenarioChanges& changes = {}) {
    std::string text = uav(vehicle);
    text.replace(text.find("kind = \"rotors\""), 15, "kind = \"arena\"" + world);
    return parse_scenario(text, folder / "a.toml", registry, changes);
  };
  const std::string hull = "model = \"models/quad.txt\"\nbody = \"hull\"\n";
  const Scenario scenario = read_in_arena("\nmodel = \"models/quad.txt\"", hull);
  const Vehicle& v = scenario.vehicles.at(0).vehicle;
  EXPECT_EQ(v.mass, 1.25);
  EXPECT_EQ(v.inertia.y, 0.02);
  EXPECT_EQ(v.k_f, Vehicle::x500().k_f);
  EXPECT_EQ(scenario.model->text, "1.25");
  EXPECT_EQ(scenario.model->folder, folder / "models");
  EXPECT_EQ(scenario.files.size(), 1u) << "a log keeps it";
  EXPECT_EQ(read_in_arena("", hull + "mass = 1.5\n").vehicles[0].vehicle.mass, 1.5);
  EXPECT_FALSE(read_in_arena("", "mass = 1.5\n").vehicles[0].model.has_value());

  // A log's scenario is read without the world and its files.
  std::filesystem::remove_all(folder / "models");
  EXPECT_EQ(read_in_arena("", hull, {.files = FileTexts{{"models/quad.txt", "no number"}}}).vehicles.size(),
            1u);
  const auto refused = [&](const std::string& vehicle) {
    std::ofstream(folder / "quad.txt") << "1.25";
    return refusal_of<ScenarioError>([&] { read_in_arena("", vehicle); });
  };
  EXPECT_THAT(refused("model = \"quad.txt\"\nbody = \"wing\"\n"),
              HasSubstr("a.toml:14: agent.uav.vehicle.body = \"wing\", expected \"hull\""));
  EXPECT_THAT(refused("body = \"hull\"\n"), HasSubstr("agent.uav.vehicle.model is missing"));
  EXPECT_THAT(refused("model = \"\"\n"),
              HasSubstr("a.toml:13: agent.uav.vehicle.model = \"\", expected the name"));
  EXPECT_THAT(
      scenario_refusal(uav(hull)),
      HasSubstr(
          "agent.uav.vehicle.model = \"models/quad.txt\", expected no such key in the world \"rotors\""))
      << "the world of rotors reads none";
}

TEST(ReadVehicle, RefusesWithFileLineAndKeyWhatCannotFly) {
  EXPECT_EQ(scenario_refusal(uav("mass = 4.0\n")),
            "a.toml:13: agent.uav.vehicle.mass = 4 kg with 4 rotors that lift 34.19 N: thrust to weight "
            "0.871, expected at least "
            "1.1");
  EXPECT_THAT(scenario_refusal(uav("preset = \"x50\"\n")),
              HasSubstr("a.toml:13: agent.uav.vehicle.preset = \"x50\", expected one of \"x500\", "));
  EXPECT_THAT(scenario_refusal(uav("mas = 4.0\n")), HasSubstr("the nearest is \"mass\""));
  EXPECT_THAT(scenario_refusal(uav("tau_up = 0.001\n")),
              HasSubstr("a.toml:13: agent.uav.vehicle.tau_up = 0.001, expected 0.004 to 1 s"));
  EXPECT_THAT(scenario_refusal(uav("spin = [1, 1, -1]\n")), HasSubstr("agent.uav.vehicle"));
  EXPECT_THAT(
      scenario_refusal(uav("rotor_x = [0.1, -0.1, 0.0]\nrotor_y = [0.1, 0.1, -0.2]\nspin = [1, -1, 1]\n")),
      HasSubstr("has 3 rotors, expected 4 to 8"));
}

TEST(ReadVehicle, RefusesATableThatNobodyWouldLookAt) {
  EXPECT_THAT(scenario_refusal(two + "\n[agent.rover.vehicle]\npreset = \"x500\"\n"),
              testing::AllOf(HasSubstr("a.toml:12: agent.rover.vehicle = "),
                             HasSubstr("the robot omni_rover is no vehicle")));
  std::string on_models = uav("preset = \"x500\"\n");
  on_models.replace(on_models.find("rotors"), 6, "model");
  EXPECT_THAT(
      scenario_refusal(on_models),
      testing::AllOf(
          HasSubstr("agent.uav.vehicle = "),
          HasSubstr("expected no such table in the world \"model\", only with world.kind = \"rotors\"")));
}

TEST(ReadVehicle, RefusesAWorldThatCannotBe) {
  EXPECT_THAT(scenario_refusal(two + "\n[horizon]\nperiod = 0.0125\n"),
              HasSubstr("the period is 0.0125 s, expected a whole number of steps"));
  EXPECT_THAT(
      scenario_refusal(uav("rotor_drag = 0\n") + "\n[simulation.disturbance]\nwind = [1.0, 0.0, 0.0]\n"),
      HasSubstr("expected one that wind, gusts, wakes and downwash can push"));
  std::string below = two;
  below.replace(below.find("1.0]"), 4, "-1.0]");
  EXPECT_THAT(scenario_refusal(below), HasSubstr("agent.uav.start.p = "));
  EXPECT_THAT(scenario_refusal(below),
              HasSubstr("expected a place at or above the ground, whose height is 0 m"));
}

/// What a flight of cooperative_localization shows from 10 s on.
class Watch final : public test::SampleSink {
 public:
  explicit Watch(const Scenario& scenario, Sample sample)
      : SampleSink(std::move(sample)), scenario_(scenario) {}
  void publish() noexcept override {
    all.insert(all.end(), sample_.x.begin(), sample_.x.end());
    all.insert(all.end(), sample_.u.begin(), sample_.u.end());
    if (sample_.time < 10.0) return;
    const Team& team = scenario_.team;
    const auto sight = [&](int i) {
      return team.model(BodyId{i}).sight(&sample_.x[static_cast<std::size_t>(team.state_offset(BodyId{i}))],
                                         &sample_.u[static_cast<std::size_t>(team.input_offset(BodyId{i}))]);
    };
    const Sight<double> a = sight(0), b = sight(1);
    angle = std::max(angle, view_angle({0.5, 0.17}, a, b.p));
    nearest = std::min(nearest, norm(a.p - b.p));
    farthest = std::max(farthest, norm(a.p - b.p));
    const double turn = 0.3 * sample_.time;
    offset = offset + (b.p - Vec3<double>{0.5 * std::cos(turn), 0.5 * std::sin(turn), 1.0});
    ++updates;
  }

  std::vector<double> all;
  Vec3<double> offset{};  // of uav1 from its circle, summed
  int updates = 0;
  double angle = 0.0, nearest = std::numeric_limits<double>::infinity(), farthest = 0.0;

 private:
  const Scenario& scenario_;
};

struct Flight {
  bool finite;
  std::string ended;
  Watch watch;
};

Flight fly(const Scenario& scenario) {
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  SimulatedClock clock;
  Watch watch(scenario, sized_sample(*world, controls.controllers()));
  const LoopOutcome outcome = ClosedLoop(scenario, *world, controls.controllers(), clock, watch).fly();
  return {outcome.finite, world->ended(), std::move(watch)};
}

Scenario cooperative(const std::string& preset, double duration) {
  const Scenario model = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml");
  Scenario scenario =
      parse_scenario(model.text, "a.toml", built_in_registry(),
                     {.set = {"world.kind=\"rotors\"", "agent.uav0.vehicle.preset=\"" + preset + "\"",
                              "agent.uav1.vehicle.preset=\"" + preset + "\""}});
  scenario.simulation.duration = duration;
  return scenario;
}

TEST(ReadVehicle, CooperativeLocalizationKeepsItsViewOnEveryVehicle) {
  for (const char* preset : {"x500", "crazyflie", "ar_drone"}) {
    const Scenario scenario = cooperative(preset, 30.0);
    const Flight flight = fly(scenario);
    EXPECT_TRUE(flight.finite) << flight.ended;
    EXPECT_LT(flight.watch.angle, 0.1) << preset;
    EXPECT_GT(flight.watch.nearest, 1.0) << preset;
    EXPECT_LT(flight.watch.farthest, 2.0) << preset;
  }
}

TEST(ReadVehicle, WithDownwashImuAndOdometryItStillKeepsItsView) {
  for (const char* preset : {"x500", "crazyflie", "ar_drone"}) {
    Scenario scenario = cooperative(preset, 30.0);
    scenario.downwash.scale = 1.0;
    for (RobotVehicle& one : scenario.vehicles) one.vehicle.imu = Imu{};
    scenario.simulation.disturbances.odometry = {.position_bias = 0.02,
                                                 .position_walk = 0.005,
                                                 .heading_bias = 0.01,
                                                 .heading_walk = 0.002,
                                                 .velocity_bias = 0.02,
                                                 .velocity_walk = 0.002,
                                                 .velocity_scale = 0.02};
    const Flight flight = fly(scenario);
    EXPECT_TRUE(flight.finite) << flight.ended;
    EXPECT_LT(flight.watch.angle, 0.2) << preset;
    EXPECT_GT(flight.watch.nearest, 1.0) << preset;
    EXPECT_LT(flight.watch.farthest, 2.0) << preset;
  }
}

// Another simulation of the same vehicle, in another engine, found 0.36 and 0.72 m.
TEST(ReadVehicle, InWindThatNobodyKnowsOfTheX500StandsAsideAsInAnotherEngine) {
  for (const double wind : {0.5, 1.0}) {
    Scenario scenario = cooperative("x500", 10 + 2 * 20.944);
    scenario.simulation.disturbances.wind = {wind, 0, 0};
    const Flight flight = fly(scenario);
    EXPECT_TRUE(flight.finite) << flight.ended;
    EXPECT_NEAR(norm(flight.watch.offset) / flight.watch.updates, 0.72 * wind, 0.05 * wind);
    EXPECT_LT(flight.watch.angle, 0.1);
  }
}

}  // namespace
}  // namespace sightline
