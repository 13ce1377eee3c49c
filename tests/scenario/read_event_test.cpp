#include "sightline/scenario/read_event.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/event_team.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

constexpr std::string_view event_scene = R"(
[agent.uav0]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0] }
sensor = { pitch = 0.5 }
[agent.uav1]
robot = "multirotor"
start = { p = [1.5, 0.0, 1.0] }
[agent.uav2]
robot = "multirotor"
start = { p = [3.0, 0.0, 1.0] }
present = false
[target.lamp]
p = [0.0, 2.0, 1.0]
present = true
[obstacle.rock]
p = [0.0, -2.0, 1.0]
present = false
[[couple]]
name = "apart"
potential = { keep_out = { d_min = 1.0 } }
between = ["uav0", "uav1"]
[simulation]
signal = [ { name = "stop" }, { at = 12.0, name = "go" }, { at = 9.0, name = "go" } ]
)";

Scenario parsed(const std::string& events) {
  return parse_scenario(fmt::format("{}{}", event_scene, events), "a.toml");
}

TEST(ReadEvent, ABodyIsThereAtFirstUnlessItIsNotPresent) {
  using enum Presence;
  EXPECT_EQ(parsed("").presence, (std::vector{steered, steered, absent, hold, absent}));
  EXPECT_TRUE(parsed("").script.empty());
}

TEST(ReadEvent, ATeamOfWhichNobodyIsPresentIsRefused) {
  try {
    parse_scenario("[agent.uav0]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\npresent = false\n", "a");
    ADD_FAILURE() << "it was read";
  } catch (const ScenarioError& error) {
    EXPECT_STREQ(error.what(),
                 "a:1: agent = {...}, expected at least one robot that is present at the start");
  }
}

TEST(ReadEvent, SignalsComeInTheOrderOfTheirTimesThoseFromOutsideNeverByThemselves) {
  const auto signals = parsed("").simulation.signals;
  ASSERT_EQ(signals.size(), 3U);
  EXPECT_EQ(signals[0].at, 9.0);
  EXPECT_EQ(signals[1].at, 12.0);
  EXPECT_EQ(signals[1].name, "go");
  EXPECT_EQ(signals[2].name, "stop");
  EXPECT_GT(signals[2].at, 1e300);
}

TEST(ReadEvent, AnEventIsWhatItsTableSaysActionsInTheOrderOfTheFile) {
  const Scenario s = parsed(R"(
[[event]]
name = "join"
stage = "start"
signal = "go"
repeat = true
observe = { observer = "uav0", target = "uav2" }
add = ["uav2", "rock"]
remove = { couple = "apart" }
enter = "watch"
ramp = 0.25
[[event]]
at = 30.0
remove = "lamp"
)");
  ASSERT_EQ(s.script.events.size(), 2U);
  const TeamEvent& event = s.script.events[0];
  EXPECT_EQ(event.name, "join");
  EXPECT_EQ(event.stage, "start");
  EXPECT_EQ(event.enter, "watch");
  EXPECT_TRUE(event.repeat);
  EXPECT_EQ(event.ramp, 0.25);
  ASSERT_EQ(event.actions.size(), 4U);
  EXPECT_EQ(std::get<Observe>(event.actions[0]).target, s.team.find("uav2"));
  EXPECT_EQ(std::get<AddBody>(event.actions[1]).body, s.team.find("uav2"));
  EXPECT_EQ(std::get<AddBody>(event.actions[2]).body, s.team.find("rock"));
  EXPECT_EQ(std::get<RemoveTerm>(event.actions[3]).name, "apart");
  EXPECT_EQ(s.script.events[1].name, "event[1]");
  EXPECT_FALSE(s.script.events[1].repeat || s.script.events[1].ramp);
}

TEST(ReadEvent, AnEventMaySpeakOfACouplingThatAnotherAdds) {
  const Scenario s = parsed(R"(
[[event]]
at = 20.0
retune = { couple = "look", weight = 0.5, potential = { sensor_cone = { alpha = 0.25 } } }
[[event]]
lost = { observer = "uav0", target = "lamp" }
remove = { couple = "look" }
[[event]]
at = 10.0
add = { couple = { name = "look", potential = { sensor_cone = { alpha = 0.5 } }, between = ["uav0", "lamp"] } }
)");
  EXPECT_EQ(std::get<RetuneTerm>(s.script.events[0].actions[0]).potential->mount()->pitch, 0.5);
  const auto& lost = std::get<Condition>(s.script.events[1].trigger);
  EXPECT_EQ(std::get<ExcessOf>(lost.measure).b, s.team.find("lamp"));
}

TEST(ReadEvent, RandomTimesOfComingAndGoingAreTakenInTurnAndRefusedOutOfTurn) {
  Random random(5);
  for (int n = 0; n < 100; ++n) {
    // uav2 comes and goes; one event more of the last kind is out of turn.
    std::vector<std::string> events;
    double t = 0.0;
    const int changes = 1 + static_cast<int>(random() % 6);
    for (int i = 0; i < changes; ++i) {
      t += uniform(random, 0.1, 5.0);
      events.push_back(fmt::format("[[event]]\nat = {}\n{} = \"uav2\"\n", t, i % 2 == 0 ? "add" : "remove"));
    }
    const std::string last =
        fmt::format("[[event]]\nat = {}\n{} = \"uav2\"\n", t + 1.0, changes % 2 == 1 ? "add" : "remove");
    std::shuffle(events.begin(), events.end(), random);
    const std::string text = fmt::format("{}", fmt::join(events, ""));
    EXPECT_EQ(parsed(text).script.events.size(), static_cast<std::size_t>(changes));
    EXPECT_THROW(parsed(text + last), ScenarioError);
  }
}

TEST(ReadEvent, AnEventSaysItsNameStageChangesAndRamp) {
  const Team team = event_team(4, 2);
  const TeamEvent event{.name = "hand over",
                        .trigger = AfterTime{2},
                        .actions = {RemoveBody{BodyId{1}}, Observe{AgentId{BodyId{3}}, BodyId{0}}},
                        .stage = "near",
                        .enter = "far"};
  EXPECT_EQ(
      describe(event, team),
      "hand over, after 2 s, in stage near: remove uav1; uav3 observes uav0; enter stage far, over 1 s");
  const TeamEvent each{.name = "e", .trigger = Signal{"go"}, .actions = {AddBody{BodyId{1}}}, .repeat = true};
  EXPECT_EQ(describe(each, team), "e, on the signal go, as often as that comes about: add uav1");
}

}  // namespace
}  // namespace sightline
