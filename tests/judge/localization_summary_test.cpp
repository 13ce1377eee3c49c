#include "sightline/judge/localization_summary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sightline/scenario.hpp"

namespace sightline {
namespace {

Scenario shipped_localize() { return read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/localize.toml"); }

/// uav0 at (1, 2, 3), heading 0, by an estimate that is off by that much.
Sample sample_at(const Scenario& scenario, double t, const Vec3<double>& off, double turned) {
  Sample sample;
  sample.time = t;
  sample.x = {1, 2, 3, 1, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0};
  sample.u.resize(static_cast<std::size_t>(scenario.team.nu()));
  sample.estimates.resize(2);
  sample.fits.resize(2);
  PoseEstimate& estimate = sample.estimates[0];
  estimate.known = true;
  estimate.p = Vec3<double>{1, 2, 3} - off;
  estimate.psi = -turned;
  estimate.P = identity<4>(0.04);
  return sample;
}

TEST(LocalizationSummary, TellsErrorAndConsistencyAfterSettle) {
  const Scenario scenario = shipped_localize();
  LocalizationSummary summary(scenario);
  summary.add(sample_at(scenario, 1.0, {5, 0, 0}, 0.0));  // before settle
  summary.add(sample_at(scenario, 7.0, {0.2, 0, 0}, 0.2));
  summary.add(sample_at(scenario, 8.0, {0, 0.2, 0.2}, 0.0));
  const std::vector<RobotLocalization> robots = summary.robots();
  ASSERT_EQ(robots.size(), 1U);
  EXPECT_EQ(robots[0].name, "uav0");
  EXPECT_EQ(robots[0].known_from, 1.0);
  EXPECT_NEAR(robots[0].rmse, std::sqrt((0.04 + 0.08) / 2), 1e-12);
  EXPECT_NEAR(robots[0].heading_rmse, std::sqrt(0.04 / 2), 1e-12);
  EXPECT_NEAR(robots[0].anees, 2.0, 1e-12);
  EXPECT_NEAR(robots[0].sigma_max, std::sqrt(0.12), 1e-12);
}

TEST(LocalizationSummary, CountsDetectionsByWhatBecameOfThem) {
  const Scenario scenario = shipped_localize();
  LocalizationSummary summary(scenario);
  const auto add = [&](double t, FitVerdict verdict) {
    Sample sample = sample_at(scenario, t, {}, 0.0);
    sample.fit_count = 1;
    sample.fits[0] = {BodyId{0}, BodyId{1}, t - 0.05, {.verdict = verdict}};
    summary.add(sample);
  };
  add(1.0, FitVerdict::started);
  add(2.0, FitVerdict::accepted);
  add(3.0, FitVerdict::rejected);
  add(4.0, FitVerdict::rejected);
  add(5.0, FitVerdict::restarted);
  add(5.5, FitVerdict::accepted);
  const RobotLocalization robot = summary.robots()[0];
  EXPECT_EQ(robot.detections, 6);
  EXPECT_EQ(robot.rejected, 2);
  EXPECT_EQ(robot.restarts, 1);
  EXPECT_NEAR(robot.longest_without_sight, 4.0 - 1.95, 1e-12);
}

TEST(LocalizationSummary, WhereNobodyKnowsTheTruthThereIsNoError) {
  const Scenario scenario = shipped_localize();
  LocalizationSummary summary(scenario);
  Sample sample = sample_at(scenario, 7.0, {}, 0.0);
  sample.truth_known = false;
  summary.add(sample);
  const RobotLocalization robot = summary.robots()[0];
  EXPECT_TRUE(std::isnan(robot.rmse));
  EXPECT_TRUE(std::isnan(robot.anees));
  const auto json = nlohmann::json::parse(summary.json());
  EXPECT_TRUE(json[0]["rmse"].is_null());
  EXPECT_EQ(json[0]["agent"], "uav0");
}

TEST(LocalizationSummary, WhereNobodyIsLocalizedByViewNothingIsSaid) {
  const Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/line_of_sight.toml");
  EXPECT_EQ(LocalizationSummary(scenario).json(), "");
}

}  // namespace
}  // namespace sightline
