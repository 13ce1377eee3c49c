// Flights of scenarios with zones, by their own solvers and barriers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sightline/safety/zone.hpp"
#include "tests/support/scenario_flight.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

/// Robot a is to fly into a pond and on through the wall of the room; robot b lands.
Scenario pond_in_a_room(const std::string& barrier) {
  return test::scenario_of(fmt::format(R"(
[simulation]
duration = 12.0
[agent.a]
robot = "multirotor"
start = {{ p = [0.0, 0.2, 1.0] }}
Q = [2.0, 2.0, 2.0, 0.2, 0.2, 0.0, 0.0]
reference = {{ steps = {{ times = [0.0, 5.0], p = [[3.0, 0.0, 1.0], [-9.0, 0.0, 1.0]] }} }}
[agent.b]
robot = "multirotor"
start = {{ p = [0.0, 3.5, 1.5] }}
Q = [2.0, 2.0, 2.0, 0.2, 0.2, 0.0, 0.0]
reference = {{ constant = {{ p = [0.0, 3.5, 1.5] }} }}
[[event]]
at = 2.0
remove = {{ agent = "b", then = "land" }}
[safety]
d_hard = 0.4
floor = 0.1
barrier = "{}"
[[safety.zone]]
polygon = [[2, -2], [4, -2], [4, 2], [2, 2]]
keep = "outside"
[[safety.zone]]
polygon = [[-3, -5], [8, -5], [8, 5], [-3, 5]]
from = 0.7
keep = "inside"
)",
                                       barrier));
}

/// Least reserve of robot a in each zone, samples alone.
std::vector<double> least_reserves(const Scenario& scenario, const TeamFlight& flight) {
  const std::vector<Zone>& zones = scenario.safety->barrier_options.zones;
  std::vector<double> least(zones.size(), infinity);
  for (const FlownPeriod& period : flight.flown) {
    for (std::size_t k = 0; k < zones.size(); ++k)
      least[k] = std::min(least[k], zone_reserve(zones[k], {period.x[0], period.x[1], period.x[2]}));
  }
  return least;
}

TEST(ZoneFlight, AReferenceBeyondAZoneDoesNotLeadThroughItsBoundary) {
  const Scenario scenario = pond_in_a_room("on");
  for (const double reserve : least_reserves(scenario, fly_scenario(scenario))) {
    EXPECT_GE(reserve, -1e-3);
    EXPECT_LE(reserve, 0.3);
  }
  const Scenario unfiltered = pond_in_a_room("off");
  for (const double reserve : least_reserves(unfiltered, fly_scenario(unfiltered))) EXPECT_LT(reserve, -0.3);
}

TEST(ZoneFlight, ARobotThatLandsGoesBelowTheFloorOfItsRoom) {
  const Scenario scenario = pond_in_a_room("on");
  const TeamFlight flight = fly_scenario(scenario);
  double lowest = infinity;
  for (const FlownPeriod& period : flight.flown)
    lowest = std::min(lowest, period.x[static_cast<std::size_t>(scenario.team.state_offset(BodyId{1})) + 2]);
  EXPECT_LT(lowest, 0.3);
}

}  // namespace
}  // namespace sightline
