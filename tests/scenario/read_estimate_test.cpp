#include "sightline/scenario/read_estimate.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/scenario.hpp"
#include "sightline/scenario/read_safety.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::scenario_of;
using test::scenario_refusal;
using testing::ElementsAre;
using testing::HasSubstr;

/// Robots in a row, each observes the one before it and has a camera and tags.
std::string row(int robots, const std::string& of_each = "") {
  std::string text;
  for (int i = 0; i < robots; ++i)
    text += fmt::format(R"toml(
[agent.uav{0}]
robot = "multirotor"
start = {{ p = [{1}.0, 0.0, 1.0], heading = 3.14 }}
{2}
[agent.uav{0}.sensor]
pitch = 0.2
[agent.uav{0}.camera]
rate = {3}.0
[agent.uav{0}.tags]
)toml",
                        i, 2 * i, i > 0 ? of_each : "", 20 + i);
  for (int i = 1; i < robots; ++i)
    text += fmt::format(R"toml(
[[couple]]
potential = {{ bearing = {{ alpha = 0.5 }} }}
between = ["uav{}", "uav{}"]
felt_by = ["uav{}"]
)toml",
                        i, i - 1, i);
  return text;
}
const std::string by_view = "localization = \"vision\"\n";

TEST(ReadEstimate, ARobotIsLocalizedByThoseThatItsCouplingsWatch) {
  const Scenario scenario = scenario_of(row(3, by_view) +
                                        "[[couple]]\npotential = { too_near = { d_min = 1.0 } }\n"
                                        "between = [\"uav2\", \"uav0\"]\nfelt_by = [\"uav2\"]\n");
  ASSERT_EQ(scenario.localization.robots.size(), 2U);
  const LocalizedRobot& last = scenario.localization.robots[1];
  EXPECT_EQ(last.robot, BodyId{2});
  EXPECT_THAT(last.observes, ElementsAre(BodyId{1})) << "a distance is no sensor";
  EXPECT_EQ(last.mount.pitch, 0.2);
  EXPECT_EQ(last.camera_rate, 22.0);
  const TelemetryOptions telemetry = telemetry_options(scenario);
  EXPECT_EQ(telemetry.robots.size(), 2U);
  EXPECT_THAT(telemetry.broadcasters, ElementsAre(BodyId{0})) << "localized robots tell their estimates";
  const MeasuredMost most = make_world(scenario)->measured_max();
  EXPECT_EQ(most.motions, 2U);
  EXPECT_GT(most.broadcasts, 0U);
}

TEST(ReadEstimate, WhoIsLocalizedByViewSearchesWhetherTheScenarioSaysSafetyOrNot) {
  const auto guard = guard_options(scenario_of(row(3, by_view)));
  ASSERT_TRUE(guard);
  EXPECT_EQ(guard->barrier, BarrierMode::off);
  EXPECT_FALSE(guard->supervisor);
  EXPECT_THAT(guard->searchers, ElementsAre(BodyId{1}, BodyId{2}));
  const auto with = guard_options(scenario_of("[safety.search]\nrate = 0.5\n" + row(2, by_view)));
  EXPECT_EQ(with->search.rate, 0.5);
  EXPECT_FALSE(guard_options(scenario_of(row(2))));
}

TEST(ReadEstimate, WatchesNamesOthersAndLandmarksCount) {
  const std::string landmark = "[obstacle.mast]\np = [5.0, 1.0, 1.0]\n[obstacle.mast.tags]\nsize = 0.3\n";
  const Scenario scenario = scenario_of(row(2, by_view + "observes = [\"mast\", \"uav0\"]\n") + landmark);
  EXPECT_THAT(scenario.localization.robots[0].observes,
              ElementsAre(scenario.team.find("mast"), scenario.team.find("uav0")));
}

TEST(ReadEstimate, WhoTurnsByAChoiceWatchesAllThatItMayTurnTo) {
  const std::string masts =
      "[obstacle.mast]\np = [0.0, 2.0, 1.0]\ntags = {}\n[obstacle.pole]\np = [0.0, -2.0, 1.0]\ntags = {}\n";
  const auto robot = [](int i) {
    return fmt::format(
        "[agent.uav{0}]\nrobot = \"multirotor\"\nstart = {{ p = [{1}, 0.0, 1.0], heading = 3.14 }}\n"
        "localization = \"vision\"\nsensor = {{ pitch = 0.2 }}\ncamera = {{}}\ntags = {{}}\n",
        i, 2.0 + i);
  };
  const auto best = [](std::string_view targets) {
    return fmt::format(
        "[[shape]]\nbest = {{ target = [{}], observers = [\"uav0\", \"uav1\"] }}\n"
        "potential = {{ bearing = {{ alpha = 0.5 }} }}\n",
        targets);
  };
  const Scenario scenario = scenario_of(robot(0) + robot(1) + masts + best("\"mast\", \"pole\""));
  ASSERT_EQ(scenario.localization.robots.size(), 2U);
  EXPECT_THAT(scenario.localization.robots[1].observes,
              testing::UnorderedElementsAre(scenario.team.find("mast"), scenario.team.find("pole")));
  EXPECT_THAT(scenario_refusal(robot(0) + robot(1) + masts + best("\"mast\", \"uav0\", \"uav1\"")),
              HasSubstr("robots are localized in a circle"));
}

TEST(ReadEstimate, TheTeamsOptionsAreTheDefaultsOfEachRobot) {
  const Scenario scenario = scenario_of(
      "[estimate]\nfilter = \"attitude\"\ntilt_bias = 0.03\n[estimate.broadcast]\nrate = "
      "10.0\n"
      "latency = [0.01, 0.02]\nvelocity_sigma = 0.05\nacceleration = 2.0\n" +
      row(2, by_view + "[agent.uav1.estimate]\ntilt_bias = 0.01\ncamera_turn = 0.02\n"));
  const FilterOptions& filter = scenario.localization.robots[0].filter;
  EXPECT_EQ(filter.filter, FilterKind::attitude);
  EXPECT_EQ(filter.tilt_bias, 0.01);
  EXPECT_EQ(filter.camera_turn, 0.02);
  EXPECT_EQ(scenario.radio.rate, 10.0);
  EXPECT_EQ(scenario.radio.latency[1], 0.02);
  EXPECT_EQ(scenario.radio.velocity_sigma, 0.05);
  EXPECT_EQ(scenario.localization.broadcast.velocity_sigma, 0.05) << "it is told as it is supposed";
  EXPECT_EQ(scenario.localization.broadcast.acceleration, 2.0);
}

TEST(ReadEstimate, CheckSaysWhoIsLocalizedByWhom) {
  const std::string said = summary(scenario_of(row(3, by_view)));
  EXPECT_THAT(said,
              HasSubstr("localized   uav1: no position enters, by view of uav0, filter \"heading\", hop 1\n"
                        "localized   uav2: no position enters, by view of uav1, filter \"chain\", hop 2\n"
                        "broadcast   uav0: its pose at 100 Hz, 0.01 m and 0.01 rad, latency 0 to 0 s\n"));
}

TEST(ReadEstimate, ItsViewsShrinkByTheSigmasOfItsSensorInSolversThatPlanSo) {
  std::string text = row(2, by_view);
  for (std::size_t at = 0; (at = text.find("pitch = 0.2", at)) != std::string::npos; at += 20)
    text.insert(at, "sigmas = 2.5\n");
  Scenario scenario = scenario_of(text);
  EXPECT_EQ(scenario.localization.robots[0].mount.sigmas, 2.5);
  EXPECT_EQ(scenario.team.couplings()[0].term.potential.mount()->sigmas, 2.5);
  EXPECT_THAT(
      summary(scenario),
      HasSubstr("view        uav1: regions of view shrink by 2.5 standard deviations of what it sees\n"));
  check_solvers(scenario);
  scenario.simulation.compare = {"cgmres"};
  EXPECT_THAT(
      refusal_of([&] { check_solvers(scenario); }),
      HasSubstr("the solver cgmres lets no view shrink by the sigmas of a sensor, expected newton_riccati"));
  EXPECT_THAT(
      scenario_refusal(
          row(1) +
          "[agent.b]\nrobot = \"multirotor\"\nstart = { p = [9, 0, 1] }\nsensor = { sigmas = 6.5 }\n"),
      HasSubstr("agent.b.sensor.sigmas = 6.5, expected 0 to 6"));
}

TEST(ReadEstimate, WhatCannotBeLocalizedIsRefused) {
  const auto refused = [](const std::string& text, const std::string& sentence) {
    EXPECT_THAT(scenario_refusal(text), HasSubstr(sentence));
  };
  refused(row(2, "localization = \"sight\"\n"),
          "agent.uav1.localization = \"sight\", expected one of \"global\", \"vision\"");
  std::string blind = row(2, by_view);
  blind.erase(blind.find("[agent.uav1.camera]"), 32);
  refused(blind,
          "agent.uav1.localization = \"vision\", expected \"global\", or a robot with a camera, "
          "[agent.uav1.camera]");
  std::string bare = row(2, by_view);
  bare.erase(bare.find("[agent.uav0.tags]"), 17);
  refused(
      bare,
      "agent.uav1.localization = \"vision\", expected \"global\", or a coupling by which it observes a body "
      "with "
      "tags, or such bodies under observes");
  refused(row(2, by_view + "observes = []\n"),
          "agent.uav1.observes = [], expected an array of one or more names");
  refused(row(2, by_view + "observes = [\"uav1\"]\n"),
          "agent.uav1.observes[0] = \"uav1\", expected another body than itself");
  refused(row(2, by_view + "observes = [\"uav0\", \"uav0\"]\n"),
          "agent.uav1.observes[1] = \"uav0\", expected each body once");
  refused(row(2, by_view + "observes = [\"mast\"]\n") + "[obstacle.mast]\np = [5.0, 1.0, 1.0]\n",
          "agent.uav1.observes[0] = \"mast\", expected a body with tags, mast has none");
  refused(row(2, by_view + "observes = [\"uav9\"]\n"),
          "agent.uav1.observes[0] = \"uav9\", expected a known name, the nearest is \"uav0\"");
  refused("[estimate]\nfilter = \"attitude\"\n" + row(3, by_view),
          "\"uav2\" observes \"uav1\", which is localized itself, with the filter \"attitude\", expected "
          "\"heading\"");
  refused("[estimate]\nsigma_hold = 0.7\n" + row(2), "estimate.sigma_hold = 0.7, expected a known key");
  refused("[estimate.broadcast]\nlatency = [0.2, 0.1]\n" + row(2),
          "latency = [0.2, 0.1], expected the shortest first");
  refused("[estimate.broadcast]\nsighting_rate = 3.0\n" + row(2), "estimate.broadcast.sighting_rate");
}

TEST(ReadEstimate, AHeadingThatNothingTellsIsRefusedBeforeFlight) {
  std::string text = row(2, by_view);
  const std::string camera = "[agent.uav1.camera]\n",
                    compass = "[agent.uav1.estimate]\ncompass_noise = 0.05\n";
  text.insert(text.find(camera) + camera.size(), "output = \"position\"\n");
  EXPECT_THAT(
      scenario_refusal(text),
      HasSubstr(
          "agent.uav1: the heading of uav1 is unobservable, and with it its position in the plane: a turn "
          "about uav0 changes nothing that is measured, expected a heading that is measured, by tags or a "
          "compass"));
  const Scenario with = scenario_of(text + compass);
  EXPECT_EQ(with.localization.robots[0].filter.compass_noise, 0.05);
  // Two landmarks tell it as well.
  std::string landmarks = text;
  landmarks.insert(landmarks.find(by_view), "observes = [\"mast\", \"uav0\"]\n");
  EXPECT_EQ(
      scenario_of(landmarks + "[obstacle.mast]\np = [5.0, 1.0, 1.0]\ntags = {}\n").localization.robots.size(),
      1U);
}

TEST(ReadEstimate, CirclesAreRefusedThoseThatAnEventWouldMakeToo) {
  const std::string circle = "\"uav1\" by \"uav2\", \"uav2\" by \"uav1\"";
  const std::string back =
      "{ potential = { bearing = { alpha = 0.5 } }, between = [\"uav1\", \"uav2\"], "
      "felt_by = [\"uav1\"] }";
  EXPECT_THAT(scenario_refusal(row(3, by_view) + "[[event]]\nat = 5.0\nadd = { couple = " + back + " }\n"),
              HasSubstr(circle));
  EXPECT_THAT(scenario_refusal(row(3, by_view) +
                               "[[event]]\nat = 5.0\nobserve = { observer = \"uav1\", target = \"uav2\" }\n"),
              HasSubstr(circle));
  const Scenario fused = scenario_of("[estimate]\ncycles = \"intersection\"\n" + row(3, by_view) +
                                     "[[event]]\nat = 5.0\nadd = { couple = " + back + " }\n");
  EXPECT_EQ(fused.localization.cycles, Cycles::intersected);
  EXPECT_THAT(fused.localization.robots[0].observes, ElementsAre(BodyId{0}, BodyId{2}));
}

TEST(ReadEstimate, AFilterTakesTheCorrelationTimeOfItsCameraOrItsOwn) {
  const auto of = [](const std::string& before) {
    std::string text = before + row(2, by_view);
    text.replace(text.rfind("rate = 21.0"), 11, "rate = 21.0\ncorrelation_time = 2.0");
    return scenario_of(text);
  };
  const Scenario scenario = of("");
  EXPECT_EQ(scenario.vision.camera_of(BodyId{1})->camera.correlation_time, 2.0);
  EXPECT_EQ(scenario.localization.robots[0].filter.correlation_time, 2.0);
  EXPECT_EQ(of("[estimate]\ncorrelation_time = 0.0\n").localization.robots[0].filter.correlation_time, 0.0);
  EXPECT_THAT(summary(scenario), HasSubstr("detections drawn by their noise, correlated over 2 s\n"));
  EXPECT_EQ(scenario_of(scenario.text).localization.robots[0].filter.correlation_time, 2.0) << "read again";
}

TEST(ReadEstimate, CorrelatedBroadcastsAreOneStateOfTheHeadingFilter) {
  const std::string lasting = "[estimate.broadcast]\ncorrelation_time = 1.5\n";
  const Scenario scenario = scenario_of(lasting + row(2, by_view));
  EXPECT_EQ(scenario.radio.correlation_time, 1.5);
  EXPECT_EQ(scenario.localization.broadcast.correlation_time, 1.5);
  EXPECT_THAT(summary(scenario), HasSubstr("by view of uav0, filter \"chain\""));
  EXPECT_THAT(scenario_refusal(lasting + "[estimate]\nfilter = \"attitude\"\n" + row(2, by_view)),
              HasSubstr("\"uav1\" observes \"uav0\", whose broadcast errors are correlated in time, with the "
                        "filter \"attitude\", expected \"heading\""));
}

}  // namespace
}  // namespace sightline
