// Certified views of vehicles with rotors, in wind, of a target that turns at will and at the
// robot.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <variant>
#include <vector>

#include "tests/support/campaign.hpp"
#include "tests/support/random.hpp"
#include "tests/support/sampled_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

struct RotorView {
  const char* preset;
  double command_delay, start, d_min, d_max, speed;
  bool by_vision;  // localized by what its camera sees of the target
};

constexpr const char* localized = R"(error = 0.04
velocity_error = 0.08
turn_error = 0.03
[agent.uav0.camera]
rate = 30.0
[estimate]
filter = "attitude"
)";

/// Without wind.
Scenario rotor_view(const RotorView& of) {
  return test::scenario_of(fmt::format(R"(
[world]
kind = "rotors"
[simulation]
duration = 15.0
[agent.uav0]
robot = "hover_multirotor"
parameters = {{ preset = "{0}" }}
command_delay = {1}
vehicle = {{ preset = "{0}" }}
start = {{ p = [{2}, 0.0, 1.6], heading = 0.0 }}
localization = "{3}"
sensor = {{ pitch = 0.5, offset = 0.17 }}
Q = [0.0, 0.0, 0.0, 0.0, 0.0, 0.7, 0.7]
[target.ball]
p = [0.0, 0.0, 0.6]
motion = {{ adversary = {{ agent = "uav0", speed = {4} }} }}
[target.ball.tags]
size = 0.3
distance = 0.2
[[couple]]
potential = {{ bearing = {{ alpha = 0.5, width = 0.1, tilt = 0.2 }} }}
between = ["uav0", "ball"]
weight = 4.0
[[couple]]
potential = {{ too_near = {{ d_min = {5}, kappa = 10.0 }} }}
between = ["uav0", "ball"]
weight = 4.0
[[couple]]
potential = {{ too_far = {{ d_max = {6}, kappa = 10.0 }} }}
between = ["uav0", "ball"]
weight = 8.0
[[certify_view]]
observer = "uav0"
target = "ball"
speed_max = {4}
climb_max = 0.1
wind = 1.0
outside = "return"
{7}
)",
                                       of.preset, of.command_delay, -of.start,
                                       of.by_vision ? "vision" : "global", of.speed, of.d_min, of.d_max,
                                       of.by_vision ? localized : ""));
}

/// Draws the wind of a flight, and the target's turns.
void draw_turns(Scenario& scenario, Random& random) {
  const double from = uniform(random, -4, 4), push = uniform(random, 0.0, 1.0);
  scenario.simulation.disturbances.wind = {push * std::cos(from), push * std::sin(from), 0.0};
  scenario.simulation.seed = random() % 100000;
  auto& adversary = std::get<AdversaryMotion>(*scenario.uncooperative[0].motion);
  adversary.every = uniform(random, 0.2, 3.0), adversary.aim = uniform(random, 0.0, 1.0);
}

constexpr std::array<RotorView, 4> vehicles = {{{"x500", 0.16, 2.0, 1.0, 3.0, 0.3, false},
                                                {"crazyflie", 0.114, 1.6, 0.8, 2.5, 0.3, false},
                                                {"x500", 0.16, 2.0, 1.0, 3.5, 0.25, true},
                                                {"crazyflie", 0.114, 1.6, 0.8, 2.5, 0.2, true}}};
constexpr int blocks = 4;  // of each vehicle's flights

class RotorViewCampaign : public testing::TestWithParam<int> {};

TEST_P(RotorViewCampaign, NoVehicleLosesAViewThatItCertifies) {
  const RotorView& of = vehicles[static_cast<std::size_t>(GetParam() / blocks)];
  const int flights = runs(1000 / blocks, 125);
  Random random(static_cast<std::uint64_t>(7 + GetParam() % blocks));
  Scenario scenario = rotor_view(of);
  const Team& team = scenario.team;
  int lost = 0, unannounced = 0;
  long certified = 0, active = 0, updates = 0;
  std::array<long, 12> missed{};
  for (int flight = 0; flight < flights; ++flight) {
    draw_turns(scenario, random);
    // Localization begins, by the first pictures, with an uncertain velocity.
    const double begin = of.by_vision ? 3.0 : 0.0;
    bool is_lost = false, was_announced = false;
    for (const Sample& sample : test::samples_of(scenario)) {
      const Sight<double> robot = true_sight(team, BodyId{0}, sample),
                          ball = true_sight(team, BodyId{1}, sample);
      for (std::size_t k = 0; k < 3; ++k)
        is_lost |= team.couplings()[k].term.potential.violation(robot, ball) > 0;
      unannounced += is_lost && !was_announced;
      if (sample.of != Sample::Of::update || sample.time < begin) continue;
      const ViewRecord& record = sample.views[0];
      was_announced |= !record.certified;
      ++updates, certified += record.certified, active += record.active;
      if (!record.certified) ++missed[static_cast<std::size_t>(record.least)];
    }
    lost += is_lost;
  }
  std::printf("%-10s %s, flights %d, lost %d, certified %.4f, acts in %.3f, uncertified by", of.preset,
              of.by_vision ? "by vision" : "measured", flights, lost,
              static_cast<double>(certified) / static_cast<double>(updates),
              static_cast<double>(active) / static_cast<double>(updates));
  for (std::size_t k = 0; k < missed.size(); ++k)
    if (missed[k] > 0)
      std::printf(" %s %ld", std::string(to_string(static_cast<ViewReserve>(k))).c_str(), missed[k]);
  std::printf("\n");
  EXPECT_EQ(lost, 0) << of.preset;
  EXPECT_EQ(unannounced, 0) << of.preset;
  EXPECT_GT(10 * certified, 9 * updates) << of.preset;
}

INSTANTIATE_TEST_SUITE_P(Blocks, RotorViewCampaign,
                         testing::Range(0, static_cast<int>(vehicles.size()) * blocks));

}  // namespace
}  // namespace sightline
