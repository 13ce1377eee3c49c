#include "sightline/record/thinned_recording.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

/// 2 s of a team with an event.
std::filesystem::path flown_folder() {
  const std::filesystem::path folder = test::fresh_folder();
  Scenario scenario = test::scenario_of(test::view_scenario);
  scenario.simulation.duration = 2.0;
  const Controls controls(scenario);
  SimulatedClock clock;
  EXPECT_TRUE(
      fly_logged(scenario, folder, clock, controls.controllers(), {.team_switcher = controls.team_switcher()})
          .logged);
  return folder;
}

TEST(ThinnedRecording, IsEachNthPeriodOfALongFlight) {
  const std::filesystem::path folder = flown_folder();
  const Recording whole = read_recording(folder), thinned = read_thinned_recording(folder, 65);
  EXPECT_EQ(thinned.stride, 4U);
  ASSERT_EQ(thinned.time.size(), 50U);
  EXPECT_EQ(thinned.end(), whole.end());
  EXPECT_DOUBLE_EQ(thinned.row_time(), 0.04);
  for (std::size_t row = 0; row < thinned.time.size(); ++row) {
    const std::size_t of_whole = 4 * row;
    ASSERT_EQ(thinned.time[row], whole.time[of_whole]);
    ASSERT_EQ(thinned.cost[row], whole.cost[of_whole]);
    ASSERT_EQ(thinned.controllers[0].residual[row], whole.controllers[0].residual[of_whole]);
    for (std::size_t body = 0; body < whole.bodies.size(); ++body) {
      ASSERT_EQ(norm(thinned.bodies[body].p[row] - whole.bodies[body].p[of_whole]), 0.0);
      for (std::size_t i = 0; i < whole.bodies[body].u.size(); ++i)
        ASSERT_EQ(thinned.bodies[body].u[i][row], whole.bodies[body].u[i][of_whole]);
    }
    const auto from = whole.solve_us.begin() + static_cast<std::ptrdiff_t>(of_whole);
    const auto left = std::min<std::ptrdiff_t>(4, whole.solve_us.end() - from);
    ASSERT_EQ(thinned.solve_us[row], *std::max_element(from, from + left));
  }
  EXPECT_EQ(thinned.events.size(), whole.events.size());
}

TEST(ThinnedRecording, OfAShortFlightIsTheRecording) {
  const std::filesystem::path folder = flown_folder();
  const Recording whole = read_recording(folder), thinned = read_thinned_recording(folder);
  EXPECT_EQ(thinned.stride, 1U);
  EXPECT_EQ(thinned.time, whole.time);
  EXPECT_EQ(thinned.solve_us, whole.solve_us);
}

}  // namespace
}  // namespace sightline
