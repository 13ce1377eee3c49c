// What it is worth to plan with the lean, at accelerations of the target of 2 and 3 m/s^2.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/support/campaign.hpp"
#include "tests/support/leaning_flight.hpp"

namespace sightline {
namespace {

using test::fly_leaning;
using test::LeaningTask;

SummaryValues reported(const char* what, const LeaningTask& task) {
  const SummaryValues values = fly_leaning(task).summary.values();
  const auto& pair = values.pairs.at(0);
  std::printf(
      "%.1f m/s^2, %-34s true camera %.3f rad in the mean, %.3f at most; planned 0.2 s before within %.4f "
      "RMS; "
      "distance %.2f to %.2f m; tilt %.2f rad; target %.3f m beside its circle; in view %.1f %%\n",
      task.speed * task.speed / task.radius, what, pair.view_angle_mean, pair.view_angle_max,
      pair.planned_view_rms, pair.distance_min, pair.distance_max, values.robots.at(0).tilt_max,
      values.robots.at(1).rms_position_error, 100 * pair.in_view_fraction);
  std::fflush(stdout);
  EXPECT_EQ(values.not_finite, 0) << what;
  EXPECT_EQ(values.applied_violations, 0) << what;
  return values;
}

TEST(BodyCameraCampaign, TheTrueCameraKeepsATargetThatFliesACircleFast) {
  const double duration = whole_campaign() ? 60.0 : 20.0;
  const auto of = [&](LeaningTask task) {
    task.duration = duration;
    return task;
  };
  reported("planned level, weight 16:", of({.frame = "level"}));
  reported("weight 4:", of({.bearing = 4.0}));
  const auto fast = reported("weight 16:", of({})).pairs.at(0);
  EXPECT_LE(fast.view_angle_mean, 0.13);
  EXPECT_LE(fast.view_angle_max, 0.28);
  EXPECT_LE(fast.planned_view_rms, 0.02);
  EXPECT_EQ(fast.in_view_fraction, 1.0);
  // A target whose own plan does not hold it on its circle: the paper's weight.
  reported("planned level, target's weight 1.5:", of({.frame = "level", .position = 1.5}));
  const auto loose = reported("weight 16, target's weight 1.5:", of({.position = 1.5})).pairs.at(0);
  EXPECT_LE(loose.view_angle_mean, 0.13);
  EXPECT_LE(loose.view_angle_max, 0.28);
  reported("planned level, weight 16:", of({.frame = "level", .radius = 2.0}));
  const auto slow = reported("weight 16:", of({.radius = 2.0})).pairs.at(0);
  EXPECT_LE(slow.view_angle_mean, 0.09);
  EXPECT_LE(slow.view_angle_max, 0.28);
  EXPECT_LE(slow.planned_view_rms, 0.02);
}

// Measured, so nothing is expected here: scripts/accept/12.sh judges it.
TEST(BodyCameraCampaign, AnUpdateWithLeanLagsAndDisturbanceIsTimedAgainstThatOfThePair) {
  Scenario pair = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml");
  pair.simulation.duration = 20.0;
  const auto median = [](const Scenario& s) {
    return test::fly_judged(s, s).summary.values().solve_us.median;
  };
  double today = 1e9, level = 1e9, leaning = 1e9;
  for (int round = 0; round < (whole_campaign() ? 15 : 2); ++round) {
    today = std::min(today, median(pair));
    LeaningTask same = {.radius = 0.5, .speed = 0.15, .bearing = 4.0, .position = 1.5};
    leaning = std::min(leaning, median(test::leaning_scenario(same)));
    same.frame = "level";
    level = std::min(level, median(test::leaning_scenario(same)));
  }
  std::printf(
      "an update in the median: %.2f us with lean, lags and disturbance, %.2f us without the lean, %.2f us "
      "cooperative_localization: ratio %.2f\n",
      leaning, level, today, leaning / today);
}

}  // namespace
}  // namespace sightline
