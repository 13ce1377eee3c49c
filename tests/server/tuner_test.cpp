#include "sightline/server/tuner.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/support/command.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/tuned_flight.hpp"

namespace sightline {
namespace {

using test::FlownCommands;
using test::fly_tuned;
using test::scenario_of;
using test::tuned_scenario;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string lighter = R"({"retune":{"couple":"bearing","weight":0.4}})";

/// Flown again from the text that it wrote, it gives the same commands, bit for bit.
void expect_same_again(const FlownCommands& flown) {
  const FlownCommands again = fly_tuned(scenario_of(flown.flight), {}, false);
  EXPECT_EQ(again.u, flown.u);
  EXPECT_EQ(again.x, flown.x);
}

// A comparison with solvers that cannot follow a change is none of a tuned flight.
TEST(Tuner, EachShippedScenarioTakesAChangeAndComesToAScenarioThatIsFlown) {
  namespace fs = std::filesystem;
  int compared = 0;
  for (const auto& entry : fs::recursive_directory_iterator(SIGHTLINE_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    if (entry.path().parent_path().filename() == "mujoco") continue;                     // built apart
    if (test::read_file(entry.path()).find("\n[agent.") == std::string::npos) continue;  // template
    SCOPED_TRACE(entry.path().native());
    Scenario scenario = read_scenario(entry.path());
    compared += scenario.simulation.compare.empty() ? 0 : 1;
    const std::size_t events = scenario.script.events.size();
    make_tunable(scenario);
    Tuner tuner(scenario);
    const Tuner::Json terms = tuner.tunables()["terms"];
    Tuner::Json change = {{"wind", {{"acceleration", {0.1, 0.0, 0.0}}}}};
    if (!terms.empty())
      change = {{"retune",
                 {{terms[0]["kind"].get<std::string>(), terms[0]["name"]},
                  {"weight", terms[0]["weight"].get<double>() + 0.1}}}};
    EXPECT_NO_THROW((void)tuner.change(change, std::nan(""), 0.0));
    ASSERT_EQ(scenario.tuned->size(), 1U);
    scenario.tuned->occur(0, scenario.horizon.dt);
    const Scenario again = parse_scenario(tuner.flight_text(), scenario.file);
    EXPECT_EQ(again.script.events.size(), events + 1);
    EXPECT_TRUE(again.simulation.compare.empty());
    EXPECT_NO_THROW((void)parse_scenario(tuner.final_text(), scenario.file));
  }
  EXPECT_GE(compared, 5);
}

TEST(Tuner, AFlightThatNobodyTunesIsTheSameFlight) {
  const std::string text = tuned_scenario(1.0);
  const FlownCommands alone = fly_tuned(scenario_of(text), {}, false),
                      armed = fly_tuned(scenario_of(text), {});
  EXPECT_EQ(alone.u, armed.u);
  EXPECT_EQ(armed.flight, text);
  EXPECT_EQ(armed.final, text);
}

// The promise of a slider: the weight of the bearing from 4.0 to 0.4, where the view counts.
TEST(Tuner, AWeightFrom4To04ChangesTheFlightWithin200MsAndStepsNoInput) {
  const std::string text = tuned_scenario(4.0);
  constexpr double period = 0.01, at = 1.5;
  const FlownCommands before = fly_tuned(scenario_of(text), {}),
                      tuned = fly_tuned(scenario_of(text), {{at, lighter}});
  double differs = 0.0;
  const auto first = static_cast<std::size_t>(at / period),
             last = static_cast<std::size_t>((at + 0.2) / period);
  for (std::size_t k = 0; k <= last; ++k) {
    for (std::size_t i = 0; i < tuned.u[k].size(); ++i) {
      const double by = std::abs(tuned.u[k][i] - before.u[k][i]);
      if (k < first) {
        EXPECT_EQ(by, 0.0);
      }
      differs = std::max(differs, by);
    }
  }
  fmt::print("a weight from 4.0 to 0.4: {:.4f} of an input within 0.2 s, largest step {:.4f}\n", differs,
             tuned.largest_step(period, at));
  EXPECT_GT(differs, 1e-3);
  EXPECT_LE(tuned.largest_step(period, at), 0.1);
  expect_same_again(tuned);
}

TEST(Tuner, ParametersReferencesBodiesWindAndFaultsChangeTheFlightWhichIsTheSameAgain) {
  std::string text = tuned_scenario(5.0);
  const FlownCommands tuned = fly_tuned(
      scenario_of(text),
      {{1.0, R"({"retune":{"couple":"bearing","potential":{"bearing":{"alpha":0.3}}}})"},
       {1.0, R"({"retune":{"couple":"couple[1]","potential":{"keep_out":{"d_min":1.2}},"weight":0.6}})"},
       {1.5, R"({"reference":{"agent":"uav1","reference":{"constant":{"p":[0.5,0.5,1.2]}}}})"},
       {2.0, R"({"move":{"obstacle":"post","p":[2.0,1.0,1.0]}})"},
       {2.5, R"({"wind":{"acceleration":[0.3,-0.1,0.0]}})"},
       {3.0, R"({"fault":{"kind":"dropout","body":"uav1","for":0.3}})"},
       {3.5, R"({"fault":{"kind":"jump","body":"uav1","for":0.1,"offset":[0.05,0,0]}})"},
       {3.6, R"({"wind":{"acceleration":[0,0,0]}})"}});
  EXPECT_THAT(tuned.refusals, IsEmpty());
  expect_same_again(tuned);
  const Scenario scenario = scenario_of(text);
  const auto post = static_cast<std::size_t>(scenario.team.state_offset(scenario.team.find("post")));
  EXPECT_NEAR(tuned.x.back()[post], 2.0, 1e-9);
  EXPECT_NEAR(tuned.x.back()[post + 1], 1.0, 1e-9);
  EXPECT_THAT(tuned.flight, HasSubstr("potential = { bearing = { alpha = 0.3, tilt = 0.2, width = 0.1 } }"))
      << "what is left out stays";
  // The values that came last, from the start.
  const Scenario final = scenario_of(tuned.final);
  EXPECT_EQ(final.team.couplings()[0].term.potential.alpha(), 0.3);
  EXPECT_EQ(final.team.couplings()[1].term.weight, 0.6);
  EXPECT_EQ(final.team.couplings()[1].term.potential.d_min(), 1.2);
  EXPECT_EQ(final.x0[post], 2.0);
  EXPECT_TRUE(final.script.empty());
}

TEST(Tuner, ChangesThatComeAtOnceHappenOneAfterTheOther) {
  const FlownCommands tuned =
      fly_tuned(scenario_of(tuned_scenario(1.0)), {{0.2, R"({"retune":{"couple":"bearing","weight":3.0}})"},
                                                   {0.2, R"({"retune":{"couple":"bearing","weight":2.0}})"},
                                                   {0.2, R"({"retune":{"couple":"bearing","weight":1.0}})"}});
  EXPECT_THAT(tuned.refusals, IsEmpty());
  EXPECT_THAT(tuned.flight, HasSubstr("at = 0.21"));
  EXPECT_THAT(tuned.flight, HasSubstr("at = 0.23"));
  expect_same_again(tuned);
}

// With the sentence that `check` has for the same event in a file.
TEST(Tuner, WhatCannotBeIsRefusedAsCheckRefusesIt) {
  Scenario scenario = scenario_of(tuned_scenario(1.0));
  scenario.tuned = std::make_shared<TunedScript>();
  Tuner tuner(scenario);
  const auto refused = [&](const std::string& change, const std::string& sentence, double ramp = 0.5) {
    const std::string said =
        refusal_of<std::invalid_argument>([&] { (void)tuner.change(Tuner::Json::parse(change), ramp, 0.1); });
    EXPECT_THAT(said, HasSubstr(sentence)) << change;
  };
  refused(R"({"retune":{"couple":"bearing","weight":-1}})", "event[0].retune.weight = -1, expected >= 0");
  refused(R"({"retune":{"couple":"bering","weight":1}})", "retune.couple = \"bering\"");
  refused(R"({"retune":{"couple":"bearing","potential":{"bearing":{"alpha":9}}}})", "alpha = 9");
  refused(R"({"retune":{"couple":"bearing"}})", "expected weight or potential");
  refused(R"({"retune":{"agent":"uav0","Q":[1]}})", "change at once");
  refused(R"({"retune":[{"agent":"uav0","Q":[1]}]})", "change at once");
  refused(R"({"move":{"obstacle":"uav0","p":[1,2,3]}})", "obstacle = \"uav0\"");
  refused(R"({"wind":[1,0,0]})", "expected a table with acceleration");
  refused(R"({"fault":{"kind":"delay","body":"uav1","for":1}})", "kind = \"delay\"");
  refused(R"({"fault":{"kind":"jump","body":"uav1","for":1}})", "offset");
  refused(R"({"fault":{"kind":"freeze","body":"uav1","for":0}})", "for = 0");
  refused(R"({"remove":"uav1"})", "event.remove, expected one of retune, reference, move, wind, fault");
  refused(R"({"at":3,"retune":{"couple":"bearing","weight":1}})", "event.at, expected one of");
  refused(R"({})", "expected an object");
  refused(R"([1])", "expected an object");
  refused(R"({"retune":null})", "null, expected");
  refused(lighter, "ramp = 0, expected 0.1 to 60 s", 0.0);
  refused(lighter, "ramp = 1000", 1000.0);
  EXPECT_EQ(scenario.tuned->size(), 0U);
  for (std::size_t i = 0; i < 3; ++i) (void)tuner.change(Tuner::Json::parse(lighter), 0.5, 0.1);
  EXPECT_EQ(scenario.tuned->size(), 3U);
}

TEST(Tuner, OfAFlightOverLinksTheTeamAloneIsTuned) {
  Scenario scenario = scenario_of(tuned_scenario(1.0));
  make_tunable(scenario, TunedScript::Scope::team);
  Tuner tuner(scenario);
  for (const char* change :
       {R"({"move":{"obstacle":"post","p":[1,2,3]}})", R"({"wind":{"acceleration":[0.1,0,0]}})",
        R"({"fault":{"kind":"freeze","body":"uav1","for":1}})"}) {
    const std::string said =
        refusal_of<std::invalid_argument>([&] { (void)tuner.change(Tuner::Json::parse(change), 0.5, 0.1); });
    EXPECT_THAT(said, HasSubstr("expected one of retune, reference")) << change;
    EXPECT_THAT(said, testing::Not(HasSubstr("wind, fault"))) << change;
  }
  EXPECT_EQ(scenario.tuned->size(), 0U);
  const Tuner::Json reported = tuner.tunables();
  for (const char* list : {"bodies", "faults"}) EXPECT_EQ(reported[list], Tuner::Json::array()) << list;
  EXPECT_TRUE(reported["wind"].is_null());
  (void)tuner.change(Tuner::Json::parse(lighter), 0.5, 0.1);
  EXPECT_EQ(scenario.tuned->size(), 1U);
}

TEST(Tuner, SaysWhatMayBeTunedWithTheBoundsThatPartsSay) {
  Scenario scenario = scenario_of(tuned_scenario(1.0));
  scenario.tuned = std::make_shared<TunedScript>();
  Tuner tuner(scenario);
  Tuner::Json reported = tuner.tunables();
  ASSERT_EQ(reported["terms"].size(), 3U);
  EXPECT_EQ(reported["terms"][0]["name"], "bearing");
  EXPECT_EQ(reported["terms"][1]["name"], "couple[1]") << "one without a name has its place";
  EXPECT_EQ(reported["terms"][0]["weight"], 4.0);
  const Tuner::Json& alpha = reported["terms"][0]["parameters"][0];
  EXPECT_EQ(alpha["key"], "alpha");
  EXPECT_EQ(alpha["value"], 0.5);
  EXPECT_EQ(alpha["unit"], "rad");
  EXPECT_EQ(alpha["low"], 0.0);
  EXPECT_TRUE(alpha["high"].is_number());
  EXPECT_EQ(reported["references"][1]["goal"], Tuner::Json({0.0, 0.0, 1.0}));
  EXPECT_EQ(reported["bodies"][0]["name"], "post");
  (void)tuner.change(Tuner::Json::parse(lighter), 0.5, 0.1);
  EXPECT_EQ(tuner.tunables()["terms"][0]["weight"], 0.4);
}

TEST(Tuner, OfATextRobotTheGoalIsInItsPositionStatesWhateverTheirNames) {
  Scenario scenario = scenario_of(R"toml([agent.car]
start = { state = [1.0, 0.0, 2.0, 3.0] }
reference = { state = [4.0, 0.0, 5.0, 6.0] }
Q = [1.0, 0.0, 1.0, 1.0]
[agent.car.robot.text]
states = ["east", "speed", "north", "up"]
inputs = ["a"]
position = ["east", "north", "up"]
f = { east = "speed", speed = "a", north = "0", up = "0" }
)toml");
  make_tunable(scenario);
  const Tuner::Json reference = Tuner(scenario).tunables()["references"][0];
  EXPECT_EQ(reference["places"], Tuner::Json({0, 2, 3}));
  EXPECT_EQ(reference["goal"], Tuner::Json({4.0, 5.0, 6.0}));
}

TEST(Tuner, WritesJsonAsToml) {
  EXPECT_EQ(toml_of(Tuner::Json::parse(R"({"a b":[1,2.0,0.1],"c":"x\"y","d":true,"e":{}})")),
            R"({ "a b" = [1, 2.0, 0.1], c = "x\"y", d = true, e = {} })");
  EXPECT_THROW((void)toml_of(nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace sightline
