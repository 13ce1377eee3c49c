/// Scenarios in which obstacles close in on a robot from all sides, judged from the true poses.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/scenario.hpp"
#include "tests/support/scenario_flight.hpp"

namespace sightline {
namespace {

/// So many chasers round the robot, which may feel them.
Scenario surrounded(int count, double speed, double far, bool felt, const std::string& barrier) {
  std::string text = fmt::format(R"(
[simulation]
duration = 10.0
[safety]
barrier = "{}"
d_hard = 0.6
floor = 0.3
[agent.uav0]
robot = "multirotor"
start = {{ p = [0.0, 0.0, 1.0] }}
Q = [1.0, 1.0, 1.0, 0.0, 0.0, 0.5, 0.5]
reference = {{ state = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0] }}
)",
                                 barrier);
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * 3.14159 * i / count;
    text += fmt::format(R"(
[obstacle.o{0}]
p = [{1}, {2}, 1.0]
motion = {{ chase = {{ agent = "uav0", speed = {3} }} }}
speed_max = {3}
)",
                        i, far * std::cos(angle), far * std::sin(angle), speed);
    if (felt) {
      text += fmt::format(R"(
[[couple]]
potential = {{ keep_out = {{ d_min = 1.0 }} }}
between = ["uav0", "o{}"]
felt_by = ["uav0"]
weight = 4.0
)",
                          i);
    }
  }
  return parse_scenario(text, "surrounded.toml");
}

struct Nearness {
  double nearest = 1e9, lowest = 1e9;
};

Nearness nearness(const Scenario& scenario) {
  const TeamFlight flight = fly_scenario(scenario);
  EXPECT_TRUE(flight.outcome.finite);
  Nearness flown;
  for (const FlownPeriod& period : flight.flown) {
    const auto at = [&](int body) {
      const double* x = &period.x[static_cast<std::size_t>(scenario.team.state_offset(BodyId{body}))];
      return Vec3<double>{x[0], x[1], x[2]};
    };
    flown.lowest = std::min(flown.lowest, at(0).z);
    for (int i = 1; i < scenario.team.bodies(); ++i)
      flown.nearest = std::min(flown.nearest, norm(at(0) - at(i)));
  }
  return flown;
}

TEST(SurroundedFlights, KeepDistanceAndFloorWithAndWithoutPotentials) {
  struct ChaserRing {
    int count;
    double speed, far;
  };
  for (const ChaserRing& ring : {ChaserRing{3, 0.5, 4.0}, {4, 1.0, 4.0}, {6, 1.0, 4.0}}) {
    for (const bool felt : {false, true}) {
      const Nearness on = nearness(surrounded(ring.count, ring.speed, ring.far, felt, "on"));
      EXPECT_GE(on.nearest, 0.6) << ring.count << (felt ? " felt" : "");
      EXPECT_GE(on.lowest, 0.3 - 1e-9);
    }
  }
  EXPECT_LT(nearness(surrounded(3, 0.5, 4.0, false, "off")).nearest, 0.1) << "without the barrier they meet";
}

}  // namespace
}  // namespace sightline
