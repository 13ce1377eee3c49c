#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "sightline/log.hpp"
#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/passing_sink.hpp"
#include "tests/support/replayed_flight.hpp"

namespace sightline {
namespace {

using test::replayed;
using test::ReplayedFlight;

ReplayedFlight shipped(const std::string& name, double duration, Clock& clock) {
  return {read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/" + name + ".toml"), duration, clock};
}

class Stumbling final : public Clock {
  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override { return k % 50 == 7 ? k + 4 : k; }
  bool waits_for_log() const noexcept override { return true; }
};

TEST(Replay, OfAFlightWhoseTeamChangesTheCommandsAreTheSameBitForBit) {
  SimulatedClock clock;
  const ReplayedFlight flown = shipped("join_and_leave", 25.0, clock);
  RecordedFlight flight = flown.flight();
  const CommandComparison compared = replayed(flown.scenario, flight);
  EXPECT_EQ(compared.updates(), 2500);
  EXPECT_EQ(compared.commands(), 2500 * static_cast<std::int64_t>(flown.scenario.team.agents().size()));
  EXPECT_EQ(compared.differing(), 0);
  EXPECT_EQ(compared.other_status(), 0);
  EXPECT_FALSE(compared.first());
}

TEST(Replay, WhereABodyThatMovesJoinsTheCommandsAreTheSameBitForBit) {
  SimulatedClock clock;
  const ReplayedFlight flown(parse_scenario(R"(
[agent.a]
robot = "omni_rover"
start = { p = [-0.32, 0.96, 0.0], heading = 0.760 }
[agent.b]
robot = "omni_rover"
start = { p = [0.06, -1.55, 0.0], heading = -2.799, v = [-0.549, -0.636] }
[obstacle.chaser]
p = [-2.21, 0.65, 1.13]
motion = { chase = { agent = "a", speed = 0.355, standoff = 1.233 } }
present = false
[[couple]]
potential = { too_near = { d_min = 1.339, kappa = 10.0 } }
between = ["b", "chaser"]
weight = 1.984
[[event]]
at = 0.04
add = "chaser"
)",
                                            "chased.toml"),
                             1.0, clock);
  RecordedFlight flight = flown.flight();
  const CommandComparison compared = replayed(flown.scenario, flight);
  EXPECT_EQ(compared.updates(), 100);
  EXPECT_EQ(compared.differing(), 0);
}

TEST(Replay, OfAFlightThatMissedPeriodsTheCommandsAreTheSameBitForBit) {
  Stumbling clock;
  const ReplayedFlight flown = shipped("handover", 30.0, clock);
  RecordedFlight flight = flown.flight();
  const CommandComparison compared = replayed(flown.scenario, flight);
  EXPECT_GT(compared.updates(), 2500);
  EXPECT_LT(compared.updates(), 3000);
  EXPECT_EQ(compared.differing(), 0);
}

TEST(Replay, OnASteadyClockTeamsTakeOverWhereTheyDidWhenTheyWereReadyLate) {
  SteadyClock clock;
  const ReplayedFlight flown = shipped("join_and_leave", 8.0, clock);
  RecordedFlight flight = flown.flight();
  EXPECT_EQ(replayed(flown.scenario, flight).differing(), 0);
}

TEST(Replay, TellsTheFirstCommandThatDiffersAndHowFar) {
  SimulatedClock clock;
  const ReplayedFlight flown = shipped("cooperative_localization", 5.0, clock);
  RecordedFlight flight = flown.flight();
  const Controls controls(flown.scenario);
  CommandComparison compared(
      flight, sized_sample(flown.scenario.team, controls.controllers(), controls.team_switcher()));
  for (const RecordedPeriod& period : flight.periods()) {
    Sample* sample = compared.claim();
    sample->time = period.time;
    sample->u = period.u;
    if (flight.number(period.time) == 123) sample->u[5] += 0.25;
    if (flight.number(period.time) == 200) sample->u[1] = std::nextafter(sample->u[1], 1e9);
    compared.publish();
  }
  EXPECT_EQ(compared.differing(), 2);
  ASSERT_TRUE(compared.first());
  EXPECT_EQ(compared.first()->update, 123);
  EXPECT_EQ(compared.first()->robot, "uav1");
  EXPECT_EQ(compared.first()->input, flown.scenario.team.agents()[1].model.inputs()[1]);
  EXPECT_NEAR(compared.first()->replayed - compared.first()->recorded, 0.25, 1e-15);
  const auto robots = compared.robots();
  EXPECT_EQ(robots[0].differing, 1);
  EXPECT_NEAR(robots[1].largest, 0.25, 1e-15);
  EXPECT_NEAR(robots[1].rms, 0.25 / std::sqrt(500 * 4), 1e-15);
  EXPECT_NEAR(robots[1].largest_at, 1.23, 1e-12);
}

// The file does not say when they arrive.
TEST(Replay, SignalsFromOutsideArriveAgainWhenEventsOccurredByThem) {
  Scenario scenario = parse_scenario(R"(
[agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0] }
Q = [1.5, 1.5, 1.6, 1, 1, 0, 0]
reference = { constant = { p = [0.5, 0.0, 1.0], heading = 0.5 } }
[simulation]
duration = 2.0
signal = [ { name = "go" }, { name = "heavy" } ]
[[event]]
stage = "moved"
signal = "heavy"
repeat = true
retune = { agent = "a", R = [2.0, 2.0, 2.0, 2.0] }
[[event]]
signal = "go"
reference = { agent = "a", reference = { constant = { p = [1.5, 0.0, 1.0], heading = 1.5 } } }
enter = "moved"
)",
                                     "signals.toml");
  lift_deadline(scenario.solver);
  const test::Folder folder("signals");
  {
    const Controls controls(scenario);
    SimulatedClock clock;
    std::optional<test::PassingSink> sink;
    FlightOptions options{.team_switcher = controls.team_switcher()};
    options.watched = [&](Sink<Sample>& log, const Sample&) -> Sink<Sample>& {
      return sink.emplace(log, [&](Sample& sample) {
        const auto k = std::llround(sample.time / scenario.horizon.dt);
        // The first "heavy" is lost, because its event waits for its stage.
        if (k == 30 || k == 110 || k == 150) controls.team_switcher()->signal("heavy");
        if (k == 80) controls.team_switcher()->signal("go");
      });
    };
    ASSERT_TRUE(fly_logged(scenario, folder.path(), clock, controls.controllers(), options).logged);
  }
  const std::filesystem::path log = folder.path() / "run.mcap";
  const Scenario again = flown_scenario(flown_as(log), log, built_in_registry());
  EXPECT_EQ(again.simulation.signals.size(), 2U + 3U);
  RecordedFlight flight(log, again.team, again.x0, again.horizon.dt);
  const CommandComparison compared = replayed(again, flight);
  EXPECT_EQ(compared.updates(), 200);
  EXPECT_EQ(compared.differing(), 0);
}

TEST(Replay, ALogSaysHowItWasFlown) {
  SimulatedClock clock;
  const ReplayedFlight flown = shipped("pyramid_camera", 0.5, clock);
  const FlownAs as = flown_as(flown.file());
  EXPECT_EQ(as.text, flown.scenario.text);
  EXPECT_EQ(as.solver, "newton_riccati");
  ASSERT_TRUE(as.files.contains("sensors/camera.toml")) << "the sensor that it names is in the log";
  EXPECT_EQ(parse_scenario(as.text, "nowhere/log", built_in_registry(), {.files = as.files})
                .team.couplings()
                .size(),
            flown.scenario.team.couplings().size());
  EXPECT_THROW(parse_scenario(as.text, "nowhere/log", built_in_registry(), {.files = FileTexts{}}),
               ScenarioError);
}

}  // namespace
}  // namespace sightline
