// Flights with a camera that is fixed to a body that leans.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sightline/log.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/leaning_flight.hpp"

namespace sightline {
namespace {

using test::fly_leaning;

/// The recording of a scenario's flight.
Recording recorded(const Scenario& scenario, std::string_view name) {
  const Controls controls(scenario);
  SimulatedClock clock;
  const auto folder = test::place(name);
  EXPECT_TRUE(fly_logged(scenario, folder, clock, controls.controllers()).logged);
  return read_recording(folder);
}

TEST(BodyCamera, PlannedWithItsLeanSeesBetterThanPlannedLevel) {
  const auto pair_of = [](std::string_view frame) {
    const SummaryValues values = fly_leaning({.frame = frame}).summary.values();
    EXPECT_EQ(values.not_finite, 0);
    EXPECT_GT(values.robots.at(1).tilt_max, 0.25) << "the target at 3 m/s^2";
    return values.pairs.at(0);
  };
  const auto level = pair_of("level"), body = pair_of("body");
  EXPECT_GT(level.view_angle_mean, 0.2);
  EXPECT_LT(body.view_angle_mean, 0.5 * level.view_angle_mean);
  EXPECT_LT(body.view_angle_max, 0.2);
  EXPECT_LT(body.planned_view_rms, 0.02);
  EXPECT_EQ(body.in_view_fraction, 1.0);
}

TEST(BodyCamera, InWindThePlanHasTheLeanThatHoldsIt) {
  for (const double from : {0.0, 2.0, 4.0}) {
    const auto values = fly_leaning({.radius = 0.5,
                                     .speed = 0.15,
                                     .duration = 16.0,
                                     .wind = {1.0 * std::cos(from), 1.0 * std::sin(from), 0.0}})
                            .summary.values();
    const auto& pair = values.pairs.at(0);
    EXPECT_GT(values.robots.at(0).tilt_max, 0.09);
    EXPECT_LT(pair.planned_view_rms, 0.01) << from;
    EXPECT_LT(pair.view_angle_max, 0.05) << from;
  }
}

TEST(BodyCamera, InTheWorldOfModelsItLeansAsTheModelDoes) {
  const auto values = fly_leaning({.estimates = false, .world = "model", .duration = 12.0}).summary.values();
  const auto& pair = values.pairs.at(0);
  EXPECT_LT(pair.view_angle_mean, 0.12);
  EXPECT_LT(pair.planned_view_rms, 0.03);
  EXPECT_GT(values.robots.at(0).tilt_max, 0.1);
}

TEST(BodyCamera, TheLogHasItsTrueAttitudeAndTheRecordingItsLean) {
  const Scenario scenario = test::leaning_scenario({.duration = 3.0});
  const Recording run = recorded(scenario, "body_camera");
  ASSERT_EQ(run.pairs.size(), 1u);
  EXPECT_EQ(run.pairs[0].mount.frame, MountFrame::body);
  double largest = 0.0;
  const Recording::Body& uav = run.bodies[run.pairs[0].observer];
  ASSERT_EQ(uav.lean.size(), run.time.size());
  for (std::size_t k = 0; k < run.time.size(); ++k) {
    largest = std::max(largest, std::hypot(uav.lean[k].x, uav.lean[k].y));
  }
  EXPECT_GT(largest, 0.1);
  // Nobody else's log says anything new.
  const Scenario level = test::leaning_scenario({.frame = "level", .world = "model"});
  EXPECT_EQ(leaning_bodies(level), (std::vector<bool>{false, false}));
  Scenario in_the_model = scenario;
  in_the_model.vehicles.clear();
  EXPECT_EQ(leaning_bodies(in_the_model), (std::vector<bool>{true, false}));
}

TEST(BodyCamera, OrAnyOtherMountIsReadBackFromItsLog) {
  const Scenario scenario = read_scenario(
      SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml", built_in_registry(),
      {"simulation.duration=0.1",
       "agent.uav0.sensor={yaw=1.5,pitch=0.25,roll=-0.5,offset=[0.125,0.25,-0.5],frame=\"body\"}"});
  const Recording run = recorded(scenario, "any_mount");
  ASSERT_EQ(run.pairs.size(), 1u);
  EXPECT_EQ(run.pairs[0].mount, (SensorMount{.pitch = 0.25,
                                             .offset = {0.125, 0.25, -0.5},
                                             .frame = MountFrame::body,
                                             .yaw = 1.5,
                                             .roll = -0.5}));
  // The scenario in the log, read again.
  const auto again = observations(parse_scenario(run.scenario, "again.toml").team.couplings());
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].mount, run.pairs[0].mount);
}

}  // namespace
}  // namespace sightline
