#include "sightline/scenario/read_robot.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/robots.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::robot_of;

std::string robot_refusal(const std::string& text) {
  return refusal_of<ScenarioError>([&] { robot_of(text); });
}

Model velocity_multirotor(const std::string& parameters) {
  return robot_of("robot = \"velocity_multirotor\"\nparameters = { " + parameters + " }\n");
}

std::vector<double> rates(const Model& model, const std::vector<double>& x) {
  const std::vector<double> u(static_cast<std::size_t>(model.nu()), 0.7);
  std::vector<double> rate(x.size());
  model.f(x.data(), u.data(), rate.data());
  return rate;
}

constexpr std::string_view unicycle = R"toml([robot.text]
states = ["p_x", "p_y", "p_z", "d_x", "d_y", "v_f"]
inputs = ["u_f", "u_psi"]
position = ["p_x", "p_y", "p_z"]
heading = ["d_x", "d_y"]
u_max = [2.0, 3.0]
f.p_x = "v_f * d_x"
f.p_y = "v_f * d_y"
f.p_z = 0
f.d_x = "-(d_y * rate)"
f.d_y = "d_x * rate"
f.v_f = "a * v_f + b * u_f"
[parameters]
a = -2.5
b = "-a"
rate = "1.5 * u_psi"
)toml";

TEST(ReadRobot, ARobotAsTextIsTheRobotOfItsFormulas) {
  const Model text = robot_of(std::string(unicycle)), model = Unicycle{};
  EXPECT_EQ(text.name(), "text");
  EXPECT_EQ(text.u_max()[1], 3.0);
  EXPECT_EQ(text.u_min()[1], -1.0);
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const auto x = uniform_array<6>(random, -2, 2);
    const std::vector<double> z(x.begin(), x.end());
    EXPECT_EQ(rates(text, z), rates(model, z));
  }
}

TEST(ReadRobot, LagsMakeAHoverMultirotorOneWithTheirStates) {
  const auto read = [](const std::string& parameters) {
    return robot_of("robot = \"hover_multirotor\"\nparameters = { " + parameters + " }\n");
  };
  EXPECT_EQ(read("").nx(), 7);
  EXPECT_EQ(read("preset = \"crazyflie\"").nx(), 7);
  const Model lagging = read("preset = \"crazyflie\", tau = 0.07, tau_z = 0.229, tau_psi = 0.136");
  EXPECT_EQ(lagging.nx(), 11);
  const std::vector<double> x = {0, 0, 0, 1, 0, 0.3, 0.2, 0.5, -0.5, 0.1, 0.4};
  EXPECT_EQ(rates(lagging, x), rates(LaggingHoverMultirotor::crazyflie(), x));
  EXPECT_EQ(robot_refusal("robot = \"hover_multirotor\"\nparameters = { tau = 0.1 }\n"),
            "a:2: parameters: hover_multirotor.tau, tau_z, tau_psi = 0.1, 0, 0 s, expected all three above 0 "
            "s, or none");
}

TEST(ReadRobot, APresetSetsWhatIsNotSaidBesideIt) {
  const std::vector<double> x = {0, 0, 0, 1, 0, 0.3, 0.2, 0.1, 0.4};
  const VelocityMultirotor drone = VelocityMultirotor::ar_drone();
  EXPECT_EQ(rates(velocity_multirotor("preset = \"ar_drone\""), x), rates(drone, x));
  EXPECT_EQ(rates(velocity_multirotor("preset = \"px4\""), x), rates(VelocityMultirotor{}, x));
  EXPECT_EQ(rates(velocity_multirotor(""), x), rates(VelocityMultirotor::px4(), x));
  const Model mixed = velocity_multirotor("preset = \"ar_drone\", tau_z = 0.7, climb_max = 2.0");
  VelocityMultirotor expected = drone;
  expected.tau_z = 0.7;
  EXPECT_EQ(rates(mixed, x), rates(expected, x));
  EXPECT_EQ(mixed.u_max()[0], drone.v_max);
  EXPECT_EQ(mixed.u_max()[2], 2.0);
  EXPECT_EQ(mixed.u_min()[2], -2.0);
}

TEST(ReadRobot, TheFrameOfAVelocityIsAWord) {
  const std::vector<double> x = {0, 0, 0, 1, 0, 0.3, 0.2, 0.1, 0.4};
  EXPECT_EQ(rates(velocity_multirotor("frame = \"heading\""), x), rates(VelocityMultirotor{}, x));
  EXPECT_EQ(rates(velocity_multirotor("frame = \"level\""), x),
            rates(VelocityMultirotor{.frame = VelocityFrame::level}, x));
  EXPECT_NE(rates(velocity_multirotor("frame = \"level\""), x), rates(VelocityMultirotor{}, x));
  EXPECT_EQ(robot_refusal("robot = \"velocity_multirotor\"\nparameters = { frame = \"body\" }\n"),
            "a:2: parameters.frame = \"body\", expected one of \"heading\", \"level\"");
}

TEST(ReadRobot, LimitsThatAreLeftOutAreTheRobots) {
  const Scenario s = parse_scenario(
      "[agent.a]\nrobot = \"velocity_multirotor\"\nstart = { p = [0, 0, 1] }\n"
      "[agent.b]\nrobot = \"velocity_multirotor\"\nstart = { p = [0, 1, 1] }\n"
      "u_max = [1, 2, 0.5, 0.3]\n",
      "a.toml");
  const auto limits = [&](std::size_t i) { return s.team.agents().at(i).limits; };
  EXPECT_EQ(limits(0).u_max().at(0), (std::vector<double>{3, 3, 1, 0.78}));
  EXPECT_EQ(limits(0).u_min().at(0), (std::vector<double>{-3, -3, -1, -0.78}));
  EXPECT_EQ(limits(1).u_max().at(0), (std::vector<double>{1, 2, 0.5, 0.3}));
  EXPECT_EQ(limits(1).u_min().at(0), (std::vector<double>{-3, -3, -1, -0.78}));
}

/// A scenario whose text robot lost, doubled or exchanged some of its bytes is read, or refused
/// with a place.
TEST(ReadRobot, ADamagedTextIsARobotOrARefusalWithItsLine) {
  Random random(2);
  int refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string text(unicycle);
    for (std::size_t n = 1 + random() % 3; n > 0; --n) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text.erase(at, 1 + random() % 4);
          break;
        case 1:
          text.insert(at, 1, text[random() % text.size()]);
          break;
        default:
          std::swap(text[at], text[random() % text.size()]);
      }
    }
    const std::string said = robot_refusal(text);
    if (said.empty()) continue;
    ++refused;
    EXPECT_EQ(said.substr(0, 2), "a:") << text;
    EXPECT_GT(std::atoi(said.c_str() + 2), 0) << said;
  }
  EXPECT_GE(refused, 1000);
}

}  // namespace
}  // namespace sightline
