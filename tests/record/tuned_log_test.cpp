#include "sightline/record/tuned_log.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <tuple>

#include "sightline/log.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/passing_sink.hpp"
#include "tests/support/replayed_flight.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

/// Hands events to a flight: one that is, one that cannot be, one more.
void add_events(TunedScript& tuned) {
  for (const auto& [name, couple, weight] :
       {std::tuple{"lighter", "view", 0.1}, {"wrong", "nobody", 1.0}, {"heavier", "view", 0.8}}) {
    tuned.add({.name = name,
               .trigger = AtTime{},
               .actions = {RetuneTerm{.name = couple, .weight = weight}},
               .ramp = 0.5},
              fmt::format("retune = {{ couple = \"{}\", weight = {:.1f} }}\nramp = 0.5\nname = \"{}\"\n",
                          couple, weight, name));
  }
}

TEST(TunedLog, ATunedFlightIsFlownAgainFromItsLogWithTheSameCommands) {
  Scenario scenario = test::scenario_of(test::view_scenario);
  lift_deadline(scenario.solver);
  scenario.tuned = std::make_shared<TunedScript>();
  const test::Folder folder("tuned_log");
  std::optional<test::PassingSink> sink;
  FlightOptions options;
  options.watched = [&](Sink<Sample>& log, const Sample&) -> Sink<Sample>& {
    return sink.emplace(log, [&](Sample& sample) {
      if (sample.time >= 0.2 && scenario.tuned->size() == 0) add_events(*scenario.tuned);
    });
  };
  {
    const Controls controls(scenario);
    SimulatedClock clock;
    options.team_switcher = controls.team_switcher();
    EXPECT_TRUE(fly_logged(scenario, folder.path(), clock, controls.controllers(), options).logged);
  }
  EXPECT_TRUE(scenario.tuned->is_ignored(1));

  const std::filesystem::path log = folder.path() / "run.mcap";
  const FlownAs flown = flown_as(log);
  EXPECT_THAT(flown.text, HasSubstr("[[event]]\nat = 0.21\nretune = { couple = \"view\", weight = 0.1 }"));
  EXPECT_THAT(flown.text, HasSubstr("enter = \"tuned:1\"")) << "what could not be keeps its place";
  const Scenario again = flown_scenario(flown, log, built_in_registry());
  EXPECT_EQ(again.script.events.back().name, "heavier");
  RecordedFlight flight(log, again.team, again.x0, again.horizon.dt, {});
  const CommandComparison compared = test::replayed(again, flight);
  EXPECT_EQ(compared.updates(), 100);
  EXPECT_EQ(compared.differing(), 0);

  const Recording recording = read_recording(folder.path());
  ASSERT_EQ(recording.script.size(), 4U);
  EXPECT_EQ(recording.script[1], "lighter");
}

}  // namespace
}  // namespace sightline
