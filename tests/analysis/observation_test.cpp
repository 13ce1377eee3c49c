#include "sightline/analysis/observation.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "sightline/potentials.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"

namespace sightline {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// n robots in a ring of 1.5 m, each looking at the next by a bearing; each feels its own couplings
/// alone.
struct RobotRing {
  Team team;
  std::vector<AgentId> robots{};
  std::vector<double> x0{};

  explicit RobotRing(int n, double pitch, bool level_view = false, std::array<double, 7> Q = {}) {
    const double radius = n == 2 ? 0.75 : 1.5 / (2 * std::sin(3.1416 / n));
    for (int i = 0; i < n; ++i) {
      const double phi = 2 * 3.1416 * i / n;
      const Vec3<double> p = {radius * std::cos(phi), radius * std::sin(phi), 5.0};
      const std::array<double, 7> x = {p.x, p.y, p.z, -std::cos(phi), -std::sin(phi), 0, 0};
      robots.push_back(team.add(Multirotor{}, {.Q = i == 0 ? Q : std::array<double, 7>{},
                                               .R = {0.1, 0.1, 0.1, 0.1},
                                               .x_ref = [x](double) { return x; }}));
      x0.insert(x0.end(), x.begin(), x.end());
    }
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const AgentId a = robots[i], b = robots[(i + 1) % robots.size()];
      const SensorMount mount = {.pitch = level_view ? 0.0 : pitch, .offset = 0.1};
      team.couple(4.0 * Bearing{.mount = mount}, {a, b}, felt_by(a));
      team.couple(4.0 * TooNear{.d_min = 1.0}, {a, b}, felt_by(a));
      team.couple(4.0 * TooFar{.d_max = 2.0}, {a, b}, felt_by(a));
      team.couple(0.5 * RelativeVelocity{}, {a, b}, felt_by(a));
    }
  }
  /// How far the middle of all has gone in a flight of 8 s [m].
  double flown() const {
    NewtonRiccati mpc(team, {.T = 1.0, .N = 20, .dt = 0.02});
    const std::vector<double> x = fly(mpc, x0, 400);
    Vec3<double> gone{};
    for (std::size_t i = 0; i < x.size(); i += 7)
      gone = gone + Vec3<double>{x[i] - x0[i], x[i + 1] - x0[i + 1], x[i + 2] - x0[i + 2]};
    return norm(gone) / static_cast<double>(robots.size());
  }
};

TEST(ObservationCycles, APairThatLooksDownAtEachOtherClimbsAsItsFlightDoesAndUpwardsItSinks) {
  for (const double pitch : {0.3, -0.3}) {
    const RobotRing ring(2, pitch);
    const auto cycles = observation_cycles(ring.team, ring.x0);
    ASSERT_EQ(cycles.size(), 1u);
    EXPECT_GT(cycles[0].drift.z * pitch, 0.0);
    EXPECT_GT(ring.flown(), 4.0) << "at up to 1 m/s";
    const std::string words = to_string(cycles[0], ring.team);
    EXPECT_THAT(words, HasSubstr("uav0 observes uav1, uav1 observes uav0"));
    EXPECT_THAT(words, HasSubstr(pitch > 0 ? "climb together for ever" : "sink together for ever"));
    EXPECT_THAT(words, HasSubstr("level their sensors"));
  }
}

TEST(ObservationCycles, EachWayOutThatIsAdvisedBringsTheFlightToRest) {
  const RobotRing ring(2, 0.3);
  const auto advised = observation_cycles(ring.team, ring.x0).at(0).maneuvers;
  EXPECT_THAT(advised, Contains(HasSubstr("level")));
  EXPECT_THAT(advised, Contains(HasSubstr("hold the place of uav0")));
  EXPECT_THAT(advised, Contains(HasSubstr("altitude_band")));
  RobotRing level(2, 0.3, true), held(2, 0.3, false, {1.6, 1.6, 1.6}), banded(2, 0.3);
  for (const AgentId robot : banded.robots) {
    banded.team.constrain(1.0 * AltitudeBand{.z_min = 4.5, .z_max = 5.5}, robot);
  }
  for (const RobotRing* maneuver : {&level, &held, &banded}) {
    EXPECT_LT(maneuver->flown(), 1.0);
    const auto cycles = observation_cycles(maneuver->team, maneuver->x0);
    ASSERT_EQ(cycles.size(), 1u) << "it is a cycle still";
    EXPECT_EQ(norm(cycles[0].drift), 0.0);
    EXPECT_THAT(to_string(cycles[0], maneuver->team), HasSubstr("comes to rest"));
  }
}

TEST(ObservationCycles, AHeightHeldAloneDoesNotHelpAndIsNotTakenForAWayOut) {
  const RobotRing held(2, 0.3, false, {0, 0, 1.6});
  EXPECT_GT(held.flown(), 3.0) << "they wander sideways";
  EXPECT_GT(norm(observation_cycles(held.team, held.x0).at(0).drift), 0.0);
}

TEST(ObservationCycles, RingsOfThreeAndFourAreOneCycleEachAndClimb) {
  for (const int n : {3, 4}) {
    const RobotRing ring(n, 0.4);
    const auto cycles = observation_cycles(ring.team, ring.x0);
    ASSERT_EQ(cycles.size(), 1u);
    EXPECT_EQ(cycles[0].robots.size(), static_cast<std::size_t>(n));
    EXPECT_GT(cycles[0].drift.z, 0.0);
  }
}

TEST(ObservationCycles, AChainAndAStarHaveNone) {
  Team team;
  std::vector<AgentId> robots;
  std::vector<double> x0;
  for (int i = 0; i < 60; ++i) {
    robots.push_back(team.add(Multirotor{}));
    x0.insert(x0.end(), {1.5 * i, 0, 1, 1, 0, 0, 0});
    if (i > 0)
      team.couple(1.0 * Bearing{}, {robots.back(), robots[robots.size() / 2 - 1]}, felt_by(robots.back()));
  }
  EXPECT_THAT(observation_cycles(team, x0), IsEmpty());
}

constexpr std::string_view three = R"(
[agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0 }
sensor = { pitch = 0.3 }
[agent.b]
robot = "multirotor"
start = { p = [1.5, 0.0, 1.0], heading = 3.1 }
sensor = { pitch = 0.3 }
[agent.c]
robot = "multirotor"
start = { p = [1.5, 1.5, 1.0], heading = 3.1 }
[[couple]]
potential = { bearing = {} }
between = ["a", "c"]
felt_by = ["a"]
weight = 4.0
[[couple]]
potential = { bearing = {} }
between = ["b", "a"]
felt_by = ["b"]
weight = 4.0
)";

std::vector<ObservationCycle> with(std::string_view events) {
  return observation_cycles(parse_scenario(fmt::format("{}{}", three, events), "three.toml"));
}

TEST(ObservationCycles, AHandoverIntoACycleIsToldWithItsEvent) {
  EXPECT_THAT(with(""), IsEmpty());
  const auto cycles =
      with("[[event]]\nname = \"turn\"\nat = 5.0\nobserve = { observer = \"a\", target = \"b\" }\n");
  ASSERT_EQ(cycles.size(), 1u);
  EXPECT_EQ(cycles[0].after, "the event \"turn\"");
  EXPECT_GT(cycles[0].drift.z, 0.0);
}

TEST(ObservationCycles, StagesThatExcludeEachOtherMakeNoCycle) {
  const std::string swap =
      "[[event]]\nat = 5.0\nobserve = { observer = \"b\", target = \"c\" }\nenter = \"other\"\n"
      "[[event]]\nstage = \"other\"\nafter = 1.0\nobserve = { observer = \"a\", target = \"b\" }\n";
  EXPECT_THAT(with(swap), IsEmpty());
}

TEST(ObservationCycles, NoScenarioThatIsShippedDrifts) {
  for (const auto& entry : std::filesystem::directory_iterator(SIGHTLINE_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    for (const ObservationCycle& cycle : observation_cycles(read_scenario(entry.path())))
      EXPECT_EQ(norm(cycle.drift), 0.0) << entry.path();
  }
}

}  // namespace
}  // namespace sightline
