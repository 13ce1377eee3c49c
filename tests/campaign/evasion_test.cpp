#include "sightline/campaign/evasion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/evasion.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

Scenario paper() {
  Scenario scenario = read_scenario(std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "scenarios/paper_7_3.toml");
  scenario.simulation.duration = 20.0;
  return scenario;
}

/// A trace that is shown, one after another, the robot at (x, 0, 1) looking along +x and the
/// obstacle at (o, 0, 1).
EvasionTrace shown(const std::vector<std::array<double, 3>>& t_x_o) {
  const Scenario scenario = paper();
  const auto solver = make_solver(scenario.solver, scenario.team, scenario.horizon);
  EvasionTrace trace(scenario, section_7_3, sized_sample(scenario.team, {*solver}));
  for (const auto& [t, x, o] : t_x_o) {
    Sample& sample = *trace.claim();
    sample.time = t;
    sample.x = {x, -0.05, 1.7, 1, 0, 0, 0, 0.04, -0.05, 0.96, 0, 0, 0, o, -0.05, 1.7, 0, 0, 0};
    trace.publish();
  }
  trace.close();
  return trace;
}

TEST(EvasionTrace, TheObstacleAndTheAngleCountFromItsEntryTheDistanceAlways) {
  // At 1.46 m across and 0.74 m up the target is in the axis; from above, at 0.04, it is 1.07 rad
  // off.
  const EvasionTrace trace = shown({{1.0, 0.04, 0.5}, {15.0, -1.46, -4.0}, {16.0, -1.26, -2.5}});
  const EvasionRow& row = trace.row();
  EXPECT_NEAR(row.min_obstacle, 1.24, 1e-12);
  EXPECT_NEAR(row.min_target, 0.74, 1e-12);
  EXPECT_NEAR(row.max_target, std::hypot(1.5, 0.74), 1e-12);
  EXPECT_LT(row.max_angle, 0.2);
  EXPECT_EQ(row.first_view, 15.0);
  EXPECT_EQ(row.lost, 0.0);
}

TEST(EvasionTrace, OutOfViewCountsAfterTheFirstViewAlone) {
  const EvasionTrace trace =
      shown({{0.0, 0.04, -9}, {0.01, -1.46, -9}, {0.02, 0.04, -9}, {0.03, 0.04, -9}, {0.04, -1.46, -9}});
  EXPECT_EQ(trace.row().first_view, 0.01);
  EXPECT_NEAR(trace.row().lost, 0.02, 1e-12);
  EXPECT_GT(trace.row().max_angle, -1);
}

TEST(EvasionTrace, AFlightLeavesARowEachTenthOfASecondWithWhatWasFlown) {
  const EvasionTrace trace = evade(paper());
  const EvasionSeries& series = trace.series();
  ASSERT_EQ(series.time.size(), 200U);
  EXPECT_NEAR(series.time.back(), 19.9, 1e-9);
  EXPECT_EQ(series.inputs, (std::vector<std::string>{"u_f", "u_s", "u_z", "u_psi"}));
  double least = infinite;
  for (std::size_t k = 0; k < series.time.size(); ++k) {
    EXPECT_NEAR(series.to_target[k], norm(series.p[k] - series.target[k]), 1e-12);
    EXPECT_NEAR(series.to_obstacle[k], norm(series.p[k] - series.obstacle[k]), 1e-12);
    if (series.time[k] >= 15) least = std::min(least, series.to_obstacle[k]);
  }
  EXPECT_NEAR(trace.row().min_obstacle, least, 0.1 * 0.3);
  EXPECT_LE(trace.row().min_obstacle, least);
}

TEST(EvasionTrace, NamesThatAreNotOfTheScenarioAreRefused) {
  const Scenario scenario = paper();
  const auto said = [&](EvasionPlan plan) {
    return refusal_of([&] { EvasionTrace(scenario, plan, Sample{}); });
  };
  EvasionPlan plan = section_7_3;
  plan.obstacle = "foot";
  EXPECT_EQ(said(plan), "evasion: \"foot\" is not in the scenario, expected a body of it");
  plan = section_7_3;
  plan.target = "hand";
  EXPECT_EQ(said(plan), "evasion: no coupling by which \"uav0\" sees \"hand\", expected one");
}

TEST(EvasionTable, HasALineForEachQuantityAndSourceAndAColumnForEachRun) {
  EvasionPlan plan = section_7_3;
  plan.published = {{0.976, 0.95}, {1.064, 0.941}, {1.785, 1.931}, {0.371, 0.438}};
  const EvasionRuns flown{"mine", {shown({{15.0, -1.46, -4.0}}), shown({{15.0, -1.26, -4.0}})}};
  const auto table = evasion_table(plan, std::span(&flown, 1));
  ASSERT_EQ(table.size(), 9U);
  EXPECT_THAT(table[0], testing::ElementsAre("min d_O [m]", "published", "0.976", "0.950"));
  EXPECT_THAT(table[1], testing::ElementsAre("min d_O [m]", "mine", "2.540", "2.740"));
  EXPECT_EQ(table[6][1], "published");
  EXPECT_EQ(table[8][0], "out of view after the first view [s]");
}

}  // namespace
}  // namespace sightline
