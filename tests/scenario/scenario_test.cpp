#include "sightline/scenario.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include "sightline/potentials.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/tree.hpp"

namespace sightline {
namespace {

using test::read_file;
using test::scenario_refusal;
using test::tree;
using testing::HasSubstr;

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// The i-th robot, i metres beside the first.
std::string robot(int i = 0) {
  return fmt::format("robot = \"multirotor\"\nstart = {{ p = [1.0, {}, 3.0], heading = 0.5 }}\n", 2.0 + i);
}

std::string robots(int count) {
  std::string text;
  for (int i = 0; i < count; ++i)
    text += fmt::format("[agent.r{}]\n{}sensor = {{ pitch = 0.5 }}\n", i, robot(i));
  return text;
}

TEST(Scenario, BytesThatAreNoTextAreRefused) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    std::string bytes(1000, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    const std::string said = scenario_refusal(bytes);
    EXPECT_EQ(said.find("a.toml:"), 0U);
    EXPECT_NE(said.find("expected"), std::string::npos);
  }
}

TEST(Scenario, EachShippedScenarioIsReadAndSummedUp) {
  for (const auto& file : files_in(tree / "scenarios")) {
    const Scenario scenario = read_scenario(file);
    EXPECT_EQ(scenario.name, file.stem().string());
    const std::string written = read_file(file);
    // The text of layers is that of the whole.
    EXPECT_EQ(scenario.text == written, written.find("\nbased_on = ") == std::string::npos) << file;
    EXPECT_EQ(static_cast<int>(scenario.x0.size()), scenario.team.nx());
    const std::string text = summary(scenario);
    for (const Agent& agent : scenario.team.agents())
      EXPECT_NE(text.find(agent.name), std::string::npos) << file;
  }
}

TEST(Scenario, EachShippedScenarioOfVehiclesIsThatOfTheModelSWorldButForWhatFlies) {
  for (const auto& file : files_in(tree / "scenarios/rotors")) {
    const Scenario vehicles = read_scenario(file);
    if (vehicles.downwash.scale > 0) continue;  // the model's world has none
    const Scenario model = read_scenario(tree / "scenarios" / file.filename());
    EXPECT_EQ(vehicles.name, model.name);
    EXPECT_EQ(vehicles.world, "rotors");
    EXPECT_FALSE(vehicles.vehicles.empty()) << file;
    EXPECT_EQ(vehicles.team.bodies(), model.team.bodies());
    EXPECT_EQ(vehicles.team.couplings().size(), model.team.couplings().size());
    EXPECT_EQ(vehicles.simulation.duration, model.simulation.duration);
    EXPECT_EQ(summary(parse_scenario(vehicles.text, file)), summary(vehicles)) << file;
  }
}

TEST(Scenario, ThePaperSScenarioIsThePaperS) {
  const Scenario s = read_scenario(tree / "scenarios/paper_7_1.toml");
  EXPECT_EQ(s.x0, (std::vector<double>{-0.6, -0.3, 0.6, 1, 0, 0, 0, 0, 0, 0.5, 1, 0, 0, 0}));
  ASSERT_EQ(s.team.agents().size(), 2U);
  EXPECT_EQ(s.team.agents()[0].Q, (std::vector<double>{0, 0, 0, 0, 0, 0.7, 0.7}));
  EXPECT_EQ(s.team.agents()[1].Q, (std::vector<double>{1.5, 1.5, 1.6, 1, 1, 0, 0}));
  std::vector<double> x(7);
  s.team.agents()[1].x_ref(0.0, s.team.agents()[1].model, x);
  EXPECT_EQ(x, (std::vector<double>{0.5, 0, 1, 0, 0, 0, 0}));

  ASSERT_EQ(s.team.couplings().size(), 3U);
  for (const Coupling& coupling : s.team.couplings()) {
    EXPECT_EQ(coupling.term.weight, 0.4);
    ASSERT_EQ(coupling.felt_by.size(), 1U);
    EXPECT_EQ(s.team.name(coupling.felt_by[0]), "uav0");
  }
  const auto* cone = s.team.couplings()[0].term.potential.as<SensorCone>();
  ASSERT_NE(cone, nullptr);
  EXPECT_EQ(std::tie(cone->alpha, cone->kappa_G, cone->kappa_A, cone->mount.pitch, cone->mount.offset),
            std::make_tuple(0.5, 0.01, 2.0, 0.5, 0.17));
  EXPECT_EQ(std::tie(s.horizon.T, s.horizon.N, s.horizon.dt), std::make_tuple(1.0, 20, 0.01));
  EXPECT_EQ(s.simulation.compare, (std::vector<std::string>{"newton_riccati", "cmscgmres", "cgmres"}));
}

TEST(Scenario, TheJointScenarioDiffersInFeltByAlone) {
  const auto statements = [](const char* name) {
    std::vector<std::string> lines;
    std::ifstream in(tree / "scenarios" / name);
    for (std::string line; std::getline(in, line);) {
      line.erase(std::min(line.find('#'), line.size()));
      while (!line.empty() && line.back() == ' ') line.pop_back();
      if (line.rfind("felt_by", 0) != 0) lines.push_back(line);
    }
    return lines;
  };
  EXPECT_EQ(statements("paper_7_1.toml"), statements("paper_7_1_joint.toml"));
  const Scenario joint = read_scenario(tree / "scenarios/paper_7_1_joint.toml");
  for (const Coupling& coupling : joint.team.couplings()) EXPECT_EQ(coupling.felt_by.size(), 2U);
}

TEST(Scenario, WhatIsLeftOutHasTheDefaultsOfTheStructs) {
  const Scenario s = parse_scenario("[agent.a]\n" + robot(), "folder/least.toml");
  EXPECT_EQ(s.name, "least");
  EXPECT_EQ(s.horizon.N, Horizon{}.N);
  EXPECT_EQ(s.solver.name, "newton_riccati");
  EXPECT_EQ(s.simulation.duration, Simulation{}.duration);
  EXPECT_EQ(s.log.prediction_period, LogOptions{}.prediction_period);
  EXPECT_EQ(s.team.agents()[0].R, std::vector<double>(4, 1.0));
  EXPECT_EQ(s.team.agents()[0].limits.u_min()[0], std::vector<double>(4, -1.0));
  EXPECT_DOUBLE_EQ(s.x0[3], std::cos(0.5));
  EXPECT_DOUBLE_EQ(s.x0[4], std::sin(0.5));
}

TEST(Scenario, RobotsComeFirstThenTargetsThenObstaclesEachInTheOrderOfTheFile) {
  const Scenario s = parse_scenario("[obstacle.z]\np = [1, 2, 3]\nv = [4, 5, 6]\n[agent.y]\n" + robot(0) +
                                        "[target.x]\np = [7, 8, 9]\n[agent.b]\n" + robot(1) +
                                        "[obstacle.a]\np = [0, 0, 0]\n",
                                    "a.toml");
  std::string names;
  for (int i = 0; i < s.team.bodies(); ++i) names += s.team.name(BodyId{i});
  EXPECT_EQ(names, "ybxza");
  EXPECT_EQ(s.targets, std::vector<BodyId>{BodyId{2}});
  EXPECT_EQ(s.obstacles, (std::vector<BodyId>{BodyId{3}, BodyId{4}}));
  const auto start = [&](int body) {
    const auto at = s.x0.begin() + s.team.state_offset(BodyId{body});
    return std::vector<double>(at, at + 6);
  };
  EXPECT_EQ(start(2), (std::vector<double>{7, 8, 9, 0, 0, 0}));
  EXPECT_EQ(start(3), (std::vector<double>{1, 2, 3, 4, 5, 6}));
}

TEST(Scenario, AStartGivesEachRobotTheVelocityAndTheHeightItHasAsStates) {
  const auto start = [](const std::string& model, const std::string& rest) {
    return parse_scenario("[agent.a]\nrobot = \"" + model + "\"\nstart = { p = [1, 2, 3], " + rest + " }\n",
                          "a.toml")
        .x0;
  };
  for (const char* model : {"multirotor", "omni_rover"})
    EXPECT_EQ(start(model, "heading = 0, v = [0.5, -0.25]"),
              (std::vector<double>{1, 2, 3, 1, 0, 0.5, -0.25}));
  EXPECT_EQ(start("point_mass", "v = [0.5, -0.25]"), (std::vector<double>{1, 2, 3, 0.5, -0.25, 0}));
  EXPECT_EQ(start("unicycle", "heading = 0, v = [0.5, 0]"), (std::vector<double>{1, 2, 3, 1, 0, 0.5}));
  EXPECT_EQ(start("velocity_multirotor", "heading = 0, v = [0.5, -0.25]"),
            (std::vector<double>{1, 2, 3, 1, 0, 0.5, -0.25, 0, 0}));
}

constexpr const char* plane = R"toml(
[agent.plane.robot.text]
states = ["x", "y", "z", "turned", "airspeed"]
inputs = ["thrust", "bank", "climb"]
position = ["x", "y", "z"]
heading = "turned"
f.x = "airspeed*cos(turned)"
f.y = "airspeed*sin(turned)"
f.z = "climb"
f.turned = "9.81*tan(bank)/airspeed"
f.airspeed = "2*thrust"
[agent.plane]
)toml";

TEST(Scenario, ARobotWhoseRatesAreNotFiniteAtRestStartsWithItsSpeed) {
  const auto start = [](const std::string& line) { return parse_scenario(plane + line + "\n", "a.toml").x0; };
  const std::vector<double> flies = {0, -60, 40, 0.5, 12};
  EXPECT_EQ(start("start = { p = [0.0, -60.0, 40.0], heading = 0.5, v = [12.0, 0.0] }"), flies);
  EXPECT_EQ(start("start = { state = [0.0, -60.0, 40.0, 0.5, 12.0] }"), flies);
  EXPECT_THAT(scenario_refusal(plane + std::string("start = { p = [0.0, -60.0, 40.0] }\n")),
              HasSubstr("start.state gives every state of a robot"));
}

TEST(Scenario, LimitsMayChangeOverTime) {
  const Scenario s = parse_scenario(
      robots(1) +
          "[agent.r0.limits]\ntimes = [0, 5]\nu_min = [[-1, -2, -3, -4], [-0.5, -0.5, -0.5, -0.5]]\n" +
          "u_max = [[1, 2, 3, 4], [0.5, 0.5, 0.5, 0.25]]\n",
      "a.toml");
  std::array<double, 4> low{}, high{};
  s.team.agents()[0].limits.at(4.9, low, high);
  EXPECT_EQ(low, (std::array<double, 4>{-1, -2, -3, -4}));
  s.team.agents()[0].limits.at(5.0, low, high);
  EXPECT_EQ(high, (std::array<double, 4>{0.5, 0.5, 0.5, 0.25}));
}

TEST(Scenario, EachDisturbanceSetsItsField) {
  const Scenario s = parse_scenario(
      robots(1) +
          "[simulation]\nseed = 7\nsettle = 8\nrms_from = 9\n[simulation.disturbance]\n"
          "wind = [1, 2, 3]\ngust = { sigma = 4, time = 5 }\n"
          "airflow = { amplitude = 6, distance = 7, frequency = 8 }\ninput_delay = 0.5\n"
          "yaw_lag = 0.25\ninput_gain = 0.9\ndelay = 0.125\n"
          "noise = { position = 0.1, heading = 0.2, velocity = 0.3 }\n"
          "odometry = { position_bias = 0.1, position_walk = 0.2, heading_bias = 0.3, "
          "heading_walk = 0.4, velocity_bias = 0.5, velocity_walk = 0.6, velocity_scale = 0.7 }\n",
      "a.toml");
  const Disturbances& d = s.simulation.disturbances;
  EXPECT_EQ(std::tie(d.wind.x, d.wind.y, d.wind.z, d.gust_sigma, d.gust_time),
            std::make_tuple(1., 2., 3., 4., 5.));
  EXPECT_EQ(std::tie(d.airflow.amplitude, d.airflow.distance, d.airflow.frequency),
            std::make_tuple(6., 7., 8.));
  EXPECT_EQ(std::tie(d.input_delay, d.yaw_lag, d.input_gain, d.measurement_delay),
            std::make_tuple(0.5, 0.25, 0.9, 0.125));
  EXPECT_EQ(std::tie(d.noise.position, d.noise.heading, d.noise.velocity), std::make_tuple(0.1, 0.2, 0.3));
  EXPECT_EQ(d.odometry, (Odometry{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}));
  EXPECT_EQ(sensor_options(s).odometry, d.odometry);
  EXPECT_EQ(std::tie(s.simulation.settle, s.simulation.rms_from), std::make_tuple(8.0, 9.0));
  EXPECT_EQ(s.simulation.seed, 7U);
}

TEST(Scenario, ALimitIsReadWithItsBarrier) {
  const Scenario s = parse_scenario(
      robots(2) +
          "[[constrain]]\nagent = \"r0\"\nlimit = { speed = { max = 0.8, mu = 0.03, delta = 0.2 } }\n"
          "[[constrain]]\nagent = \"r1\"\nlimit = { input_disc = { radius = 0.5 } }\n",
      "a.toml");
  ASSERT_EQ(s.team.barriers().size(), 2u);
  const BarrierTerm &speed = s.team.barriers()[0], &disc = s.team.barriers()[1];
  EXPECT_EQ(std::tie(speed.barrier.mu, speed.barrier.delta), std::make_tuple(0.03, 0.2));
  EXPECT_EQ(s.team.name(speed.agent), "r0");
  EXPECT_EQ(s.team.name(disc.agent), "r1");
  const Sight<double> fast{{}, {0.8, 0.0, 5.0}};
  EXPECT_NEAR(speed.barrier.limit(fast, {}, {}), 0.0, 1e-15);
  const std::array<double, 4> u = {0.3, 0.4, 1.0, 1.0};
  EXPECT_NEAR(disc.barrier.limit({}, {}, u), 0.0, 1e-15);
  EXPECT_THAT(summary(s), testing::HasSubstr("constrain   limit speed of r0, mu 0.03, delta 0.2\n"));
}

TEST(Scenario, TheSummarySaysWhoFeelsWhat) {
  const std::string text = summary(read_scenario(tree / "scenarios/paper_7_1.toml"));
  for (const char* fact : {"1 s, 20 stages, period 0.01 s", "newton_riccati", "60 s, 6000 updates, seed 1",
                           "14 states, 8 inputs", "uav1: multirotor, 7 states, 4 inputs",
                           "0.4 cohesion between uav0 and uav1, felt by uav0"})
    EXPECT_THAT(text, HasSubstr(fact));
}

TEST(Scenario, AThousandRobotsAreReadAndOneTooManyIsRefused) {
  std::string text = robots(static_cast<int>(agents_max));
  for (std::size_t i = 0; i + 1 < agents_max; ++i) {
    text += fmt::format(
        "[[couple]]\nbetween = [\"r{}\", \"r{}\"]\npotential = {{ sensor_cone = {{ alpha = 0.5 }} }}\n", i,
        i + 1);
  }
  const Scenario s = parse_scenario(text, "a.toml");
  EXPECT_EQ(s.team.agents().size(), agents_max);
  EXPECT_EQ(s.team.name(BodyId{1023}), "r1023");
  EXPECT_EQ(s.team.couplings().size(), agents_max - 1);
  EXPECT_EQ(scenario_refusal(robots(static_cast<int>(agents_max) + 1)),
            "a.toml:1: agent = {...}, expected at most 1024 robots");
}

// Bytes of a good scenario are deleted, doubled, exchanged and moved; whatever comes of it is read
// or refused.
TEST(Scenario, ASpoiltScenarioIsReadOrRefusedInOneLine) {
  // The one says everything, the other by templates and ranges.
  const std::array good = {read_file(tree / "scenarios/paper_7_1.toml"),
                           read_file(tree / "scenarios/chain8.toml")};
  std::mt19937 random(20180601);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int read = 0, refused = 0;
  for (int trial = 0; trial < 6000; ++trial) {
    std::string text = good[trial % 2 == 0 ? 0 : 1];
    for (std::size_t spoils = 1 + below(3); spoils > 0 && !text.empty(); --spoils) {
      const std::size_t at = below(text.size()), length = std::min(1 + below(40), text.size() - at);
      switch (below(6)) {
        case 0:
          text.erase(at, length);
          break;
        case 1:
          text.insert(at, text.substr(at, length));
          break;
        case 2:
          text[at] = static_cast<char>(random());
          break;
        case 3:
          text[at] = "0123456789.-+e[]{}\"'=,#\n_"[below(25)];
          break;
        case 4:
          text.insert(below(text.size()), text.substr(at, length));
          break;
        default:
          text.resize(std::max<std::size_t>(at, 1));
          break;
      }
    }
    const std::string said = scenario_refusal(text);
    if (said.empty()) {
      ++read;
      continue;
    }
    ++refused;
    EXPECT_EQ(said.rfind("a.toml:", 0), 0U) << said;
    EXPECT_TRUE(said[7] >= '1' && said[7] <= '9') << said;
    EXPECT_NE(said.find(", expected "), std::string::npos) << said;
    EXPECT_TRUE(std::none_of(said.begin(), said.end(), [](char c) {
      return c >= 0 && (c < ' ' || c == '\x7f');
    })) << said;
    EXPECT_LT(said.size(), 600U) << said;
  }
  EXPECT_GT(read, 100);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace sightline
