#include "sightline/record/tuned_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "sightline/log.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

/// Hands events to a flight at 0.2 s: one that is, one that cannot be, one more.
class TunedAtSink final : public Sink<Sample> {
 public:
  TunedAtSink(Sink<Sample>& log, TunedScript& tuned) : log_(log), tuned_(tuned) {}
  Sample* claim() noexcept override { return sample_ = log_.claim(); }
  void publish() noexcept override {
    if (sample_->time >= 0.2 && tuned_.size() == 0) {
      const auto add = [&](const std::string& name, Action action, const std::string& keys) {
        tuned_.add({.name = name, .trigger = AtTime{}, .actions = {std::move(action)}, .ramp = 0.5},
                   keys + "ramp = 0.5\nname = \"" + name + "\"\n");
      };
      add("lighter", RetuneTerm{.name = "view", .weight = 0.1},
          "retune = { couple = \"view\", weight = 0.1 }\n");
      add("wrong", RetuneTerm{.name = "nobody", .weight = 1.0},
          "retune = { couple = \"nobody\", weight = 1.0 }\n");
      add("heavier", RetuneTerm{.name = "view", .weight = 0.8},
          "retune = { couple = \"view\", weight = 0.8 }\n");
    }
    log_.publish();
  }
  void close() noexcept override { log_.close(); }

 private:
  Sink<Sample>& log_;
  TunedScript& tuned_;
  Sample* sample_ = nullptr;
};

TEST(TunedLog, ATunedFlightIsFlownAgainFromItsLogWithTheSameCommands) {
  Scenario scenario = test::scenario_of(test::view_scenario);
  lift_deadline(scenario.solver);
  scenario.tuned = std::make_shared<TunedScript>();
  const test::Folder folder("tuned_log");
  std::optional<TunedAtSink> sink;
  FlightOptions options;
  options.watched = [&](Sink<Sample>& log, const Sample&) -> Sink<Sample>& {
    return sink.emplace(log, *scenario.tuned);
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
  const Controls controls(again);
  CommandComparison compared(flight, sized_sample(flight, controls.controllers(), controls.team_switcher()));
  (void)ClosedLoop(again, flight, controls.controllers(), flight, compared, nullptr, controls.team_switcher())
      .fly();
  EXPECT_EQ(compared.updates(), 100);
  EXPECT_EQ(compared.differing(), 0);

  const Recording recording = read_recording(folder.path());
  ASSERT_EQ(recording.script.size(), 4U);
  EXPECT_EQ(recording.script[1], "lighter");
}

}  // namespace
}  // namespace sightline
