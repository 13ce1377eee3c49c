#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sightline/log.hpp"
#include "sightline/report/run_figures.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/folder.hpp"

namespace sightline {
namespace {

TEST(LocalizationFigure, WhereNobodyIsLocalizedByViewThereIsNone) {
  EXPECT_TRUE(localization_drawings(Recording{}).empty());
  Recording r;
  r.time = {0.0, 0.1};
  r.bodies.resize(2);
  EXPECT_TRUE(localization_drawings(r).empty());
}

TEST(LocalizationFigure, AFlightShowsErrorConsistencyAndDetectionsAsItsSummarySays) {
  Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/localize.toml", built_in_registry(),
                                    {"agent.uav0.camera.outliers=0.2"});
  scenario.simulation.duration = 6.0;
  scenario.simulation.settle = 1.0;
  const test::Folder folder("localization_figure_test");
  const Controls controls(scenario);
  SimulatedClock clock;
  const LoggedFlight flight = fly_logged(scenario, folder.path(), clock, controls.controllers());
  ASSERT_TRUE(flight.logged);
  const Recording recording = read_recording(folder.path());
  const Recording::Localization& of = recording.bodies[0].localization;
  EXPECT_TRUE(recording.bodies[1].localization.time.empty());
  double squares = 0.0, nees = 0.0, n = 0.0;
  for (std::size_t k = 0; k < of.time.size(); ++k) {
    if (of.time[k] < 1.0 - 1e-9) continue;
    squares += of.error[k] * of.error[k], nees += of.nees[k], ++n;
  }
  const auto reported = nlohmann::json::parse(flight.summary).at("localization").at(0);
  EXPECT_NEAR(std::sqrt(squares / n), reported.at("rmse").get<double>(), 1e-9);
  EXPECT_NEAR(nees / n, reported.at("anees").get<double>(), 1e-6);
  EXPECT_EQ(of.refused.size(), reported.at("rejected"));
  EXPECT_GT(of.refused.size(), 10U);
  EXPECT_GT(of.estimated.size(), 60U);

  const std::vector<Drawing> drawings = localization_drawings(recording);
  ASSERT_EQ(drawings.size(), 1U);
  EXPECT_EQ(drawings[0].title, "uav0 by what it sees");
  ASSERT_EQ(drawings[0].panels.size(), 3U);
  for (const Drawing::Panel& panel : drawings[0].panels) EXPECT_EQ(panel.curves.size(), 2U);
}

}  // namespace
}  // namespace sightline
