#include "sightline/judge/planned_view.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"

namespace sightline {
namespace {

constexpr double stage_time = 0.05;
constexpr std::size_t planned_stages = 9;

/// A lagging observer at the origin whose camera looks along x of the body, and a target 2 m ahead.
struct WatchedTarget {
  Team team;
  Observation pair;
  Sample sample;

  WatchedTarget()
      : pair{BodyId{0}, BodyId{1}, Potential(Bearing{}), {0.0, 0.0, MountFrame::body}, 0.5, 0.0, 0.0} {
    team.add(LaggingHoverMultirotor{}, {.name = "uav"});
    team.add(Obstacle{.name = "target"});
    sample.x.assign(11 + 6, 0.0);
    sample.x[3] = 1.0;
    sample.x[11] = 2.0;
    sample.u.resize(4);
    sample.path_step = stage_time;
    sample.path.resize(planned_stages * sample.x.size());
    sample.path_u.resize(planned_stages * sample.u.size());
  }

  /// Plans from `time` on, `late` after it, that it is pitched by `angle` at each stage; flown it
  /// is by `flown`.
  template <class Angle>
  void add(PlannedView& view, double time, double late, Angle&& angle, double flown, bool counts = true) {
    sample.time = time;
    sample.has_path = true;
    sample.path_time = time + late;
    for (std::size_t i = 0; i < planned_stages; ++i) {
      std::copy(sample.x.begin(), sample.x.end(),
                sample.path.begin() + static_cast<std::ptrdiff_t>(i * sample.x.size()));
      sample.path[i * sample.x.size() + 7] =
          gravity * std::tan(angle(sample.path_time + stage_time * static_cast<double>(i)));
    }
    view.add(team, pair, sample, flown, counts);
  }
};

TEST(PlannedView, WhatIsFlownAsItWasPlannedHasNoError) {
  for (const double late : {0.0, 0.036, 0.16, 0.2}) {
    WatchedTarget watched;
    PlannedView view;
    EXPECT_TRUE(std::isnan(view.rms()));
    const auto pitch = [](double t) { return 0.1 + 0.2 * t; };  // on a line, as between two stages
    for (int k = 0; k < 100; ++k) watched.add(view, 0.01 * k, late, pitch, pitch(0.01 * k));
    EXPECT_LT(view.rms(), 1e-12) << late;
  }
}

TEST(PlannedView, TheErrorIsThatOfTheAngleSoMuchLater) {
  WatchedTarget watched;
  PlannedView view;
  for (int k = 0; k < 100; ++k)
    watched.add(
        view, 0.01 * k, 0.0, [](double) { return 0.1; }, k < 60 ? 0.4 : 0.13);
  EXPECT_NEAR(view.rms(), std::sqrt((40 * 0.3 * 0.3 + 40 * 0.03 * 0.03) / 80), 1e-9) << "from 0.2 s on";
}

TEST(PlannedView, WhatDoesNotCountOrWasLostIsNotCompared) {
  WatchedTarget watched;
  PlannedView view;
  const auto level = [](double) { return 0.0; };
  for (int k = 0; k < 50; ++k) watched.add(view, 0.01 * k, 0.0, level, 0.3, false);
  EXPECT_TRUE(std::isnan(view.rms()));
  watched.add(view, 5.0, 0.0, level, 0.3);  // all that was planned is over
  EXPECT_TRUE(std::isnan(view.rms()));
  watched.sample.path_u.clear();
  watched.sample.time = 5.2;
  view.add(watched.team, watched.pair, watched.sample, 0.25, true);
  EXPECT_NEAR(view.rms(), 0.25, 1e-12) << "what was planned at 5 s";
}

TEST(PlannedView, MeanAndGreatestAreThoseOfWhatWasPlannedAndCompared) {
  WatchedTarget watched;
  PlannedView view;
  EXPECT_TRUE(std::isnan(view.mean()));
  EXPECT_TRUE(std::isnan(view.max()));
  for (int k = 0; k < 60; ++k) {
    const double planned = k < 20 ? 0.1 : 0.3;
    watched.add(
        view, 0.01 * k, 0.0, [&](double) { return planned; }, 0.0);
  }
  EXPECT_NEAR(view.mean(), 0.2, 1e-9) << "20 of each; those for later than the end are not compared";
  EXPECT_NEAR(view.max(), 0.3, 1e-9);
}

TEST(PlannedTilt, IsThatOfThePlannedLean) {
  WatchedTarget watched;
  PlannedTilt tilt;
  for (int k = 0; k < 50; ++k) {
    PlannedView ignored;
    watched.add(
        ignored, 0.01 * k, 0.0, [](double) { return -0.2; }, 0.0);
    tilt.add(watched.team, BodyId{0}, watched.sample, 0.25, true);
  }
  EXPECT_NEAR(tilt.max(), 0.2, 1e-9) << "whichever way it leans";
  EXPECT_NEAR(tilt.rms(), 0.05, 1e-9);
}

}  // namespace
}  // namespace sightline
