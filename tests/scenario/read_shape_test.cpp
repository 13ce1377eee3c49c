#include "sightline/scenario/read_shape.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/potentials.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scenario_text.hpp"

namespace sightline {
namespace {

using test::scenario_of;

constexpr int robot_count = 5;

/// Robots on a line, each with a sensor of its own, and a rock.
std::string line_of_robots() {
  std::string text;
  for (int i = 0; i < robot_count; ++i) {
    text += fmt::format(
        "[agent.r{0}]\nrobot = \"multirotor\"\nstart = {{ p = [{1}, 0.0, {2}], heading = 0.0 }}\n"
        "Q = [1.0, 1.0, 1.0, 0.0, 0.0, 0.7, 0.7]\nsensor = {{ pitch = {3}, offset = 0.17 }}\n"
        "reference = {{ constant = {{ p = [{4}, 0.5, 1.0] }} }}\n",
        i, -1.6 * i, 1 + 0.2 * i, 0.1 * i, -1.3 * i);
  }
  return text + "[obstacle.rock]\np = [0.0, 2.0, 1.0]\n";
}

constexpr std::string_view sensor_cone_table = "sensor_cone = { alpha = 0.5, kappa_G = 0.01, kappa_A = 2.0 }";
constexpr std::string_view keep_out_table =
    "keep_out = { d_min = 1.0, kappa_H = 4.5, kappa_G = 0.001, kappa_A = 3.0 }";

/// The couplings that a shape stands for, as one would write them.
std::string by_hand(const std::vector<std::pair<std::string, std::string>>& pairs, bool observer_alone) {
  std::string text;
  for (const auto& [first, second] : pairs) {
    for (const auto& [potential, weight] : {std::pair{sensor_cone_table, 0.4}, {keep_out_table, 1.5}}) {
      text += fmt::format("[[couple]]\npotential = {{ {} }}\nweight = {}\nbetween = [\"{}\", \"{}\"]\n",
                          potential, weight, first, second);
      if (observer_alone) text += fmt::format("felt_by = [\"{}\"]\n", first);
    }
  }
  return text;
}

std::string shape(std::string_view members, std::string_view felt_by) {
  return fmt::format(
      "[[shape]]\n{}\npotentials = [ {{ {}, weight = 0.4 }}, {{ {}, weight = 1.5 }} ]\nfelt_by = \"{}\"\n",
      members, sensor_cone_table, keep_out_table, felt_by);
}

std::string shape_refusal(const std::string& text) { return test::scenario_refusal(line_of_robots() + text); }

/// All inputs of a short flight.
std::vector<double> flown(const Scenario& s) {
  const auto solver = make_solver(s.solver, s.team, s.horizon);
  std::vector<double> inputs;
  fly(*solver, s.x0, 40, [&](double, const std::vector<double>&, const Solution& solution) {
    inputs.insert(inputs.end(), solution.u.begin(), solution.u.end());
  });
  return inputs;
}

void expect_same(const std::string& a, const std::string& b) {
  const Scenario one = scenario_of(line_of_robots() + a), other = scenario_of(line_of_robots() + b);
  EXPECT_EQ(summary(one), summary(other));
  const std::vector<double> inputs = flown(one);
  EXPECT_GT(*std::max_element(inputs.begin(), inputs.end()), 0.0);
  EXPECT_EQ(inputs, flown(other));
}

TEST(ReadShape, AChainFliesAsItsCouplingsWrittenByHandBitForBit) {
  const auto pairs = {std::pair<std::string, std::string>{"r1", "r0"}, {"r2", "r1"}, {"r3", "r2"}};
  const std::string_view members = "chain = [\"r0\", \"r1\", \"r2\", \"r3\"]";
  expect_same(shape(members, "observer"), by_hand(pairs, true));
  expect_same(shape(members, "both"), by_hand(pairs, false));
}

TEST(ReadShape, ARingAStarAndAllPairsFlyAsTheirCouplingsWrittenByHand) {
  expect_same(shape("ring = [\"r0\", \"r4\", \"r2\"]", "observer"),
              by_hand({{"r4", "r0"}, {"r2", "r4"}, {"r0", "r2"}}, true));
  expect_same(shape("star = { centre = \"r2\", observers = [\"r0\", \"r1\", \"r4\"] }", "both"),
              by_hand({{"r0", "r2"}, {"r1", "r2"}, {"r4", "r2"}}, false));
  expect_same(shape("star = { centre = \"rock\", observers = [\"r0\", \"r1\"] }", "both"),
              by_hand({{"r0", "rock"}, {"r1", "rock"}}, false));
  expect_same(shape("all_pairs = [\"r0\", \"r1\", \"rock\"]", "observer"),
              by_hand({{"r0", "r1"}, {"r0", "rock"}, {"r1", "rock"}}, true));
}

TEST(ReadShape, OnePotentialWithAWeightStandsAsInACoupling) {
  const Scenario s =
      scenario_of(line_of_robots() + fmt::format("[[shape]]\nall_pairs = \"all\"\npotential = {{ {} }}\n"
                                                 "weight = 3.0\n",
                                                 keep_out_table));
  ASSERT_EQ(s.team.couplings().size(), static_cast<std::size_t>(robot_count * (robot_count - 1) / 2));
  for (const Coupling& coupling : s.team.couplings()) {
    EXPECT_EQ(coupling.term.weight, 3.0);
    EXPECT_EQ(coupling.felt_by.size(), 2U);
    EXPECT_NE(coupling.term.potential.as<KeepOut>(), nullptr);
  }
}

TEST(ReadShape, EachObserverLooksWithItsOwnSensor) {
  const Scenario s =
      scenario_of(line_of_robots() + shape("ring = [\"r0\", \"r1\", \"r2\", \"r3\", \"r4\"]", "observer"));
  int seen = 0;
  for (const Coupling& coupling : s.team.couplings()) {
    const SensorMount* mount = coupling.term.potential.mount();
    if (mount == nullptr) continue;
    ++seen;
    EXPECT_DOUBLE_EQ(mount->pitch, 0.1 * coupling.between.first.index);
  }
  EXPECT_EQ(seen, robot_count);
}

TEST(ReadShape, AShapeOfTooManyCouplingsIsRefusedBeforeItIsMade) {
  std::string text;
  for (int i = 0; i < 500; ++i) {
    text += fmt::format("[agent.r{}]\nrobot = \"multirotor\"\nstart = {{ p = [{}, 0, 1] }}\n", i, i);
  }
  text += fmt::format("[[shape]]\nall_pairs = \"all\"\npotential = {{ {} }}\n", keep_out_table);
  try {
    scenario_of(text);
    ADD_FAILURE() << "it was read";
  } catch (const ScenarioError& error) {
    EXPECT_STREQ(error.what(),
                 "a.toml:1502: shape[0].all_pairs = \"all\", expected at most 100000 couplings");
  }
}

TEST(ReadShape, APotentialOfAListIsRefusedWhereItStands) {
  EXPECT_EQ(shape_refusal("[[shape]]\nchain = [\"r0\", \"r1\"]\npotentials = [\n  { keep_out = {} },\n"
                          "  { keep_out = { d_min = -1.0 } },\n]\n"),
            "a.toml:37: shape[0].potentials[1].keep_out.d_min = -1, expected > 0 m");
}

TEST(ReadShape, TheNearestObservesByEventsOfItsOwn) {
  const std::string nearest = fmt::format(
      "[[shape]]\nname = \"rover\"\nnearest = {{ target = \"r0\", observers = [\"r1\", \"r2\", \"r3\"], "
      "margin = "
      "0.2, dwell = 0.5, ramp = 0.8 }}\npotentials = [ {{ {}, weight = 0.4 }}, {{ {}, weight = 1.5 }} ]\n",
      sensor_cone_table, keep_out_table);
  const Scenario s = scenario_of(line_of_robots() + nearest);
  EXPECT_EQ(s.team.couplings().size(), 2U);
  ASSERT_EQ(s.script.events.size(), 6U);
  for (const TeamEvent& event : s.script.events) {
    EXPECT_EQ(event.ramp, 0.8);
    const auto& when = std::get<Condition>(event.trigger);
    EXPECT_EQ(when.threshold, 0.2);
    EXPECT_EQ(when.dwell, 0.5);
  }
  EXPECT_TRUE(changes_in_flight(s));
  EXPECT_EQ(shape_refusal(nearest + nearest)
                .find("a.toml:38: shape[1].name = \"rover\", expected a name of its own"),
            0U)
      << shape_refusal(nearest + nearest);
  EXPECT_EQ(shape_refusal("[[shape]]\nnearest = { target = \"r0\", observers = [\"r1\", \"r0\"] }\n"
                          "potential = { keep_out = {} }\n"),
            "a.toml:34: shape[0].nearest.observers[1] = \"r0\", expected a robot other than the target");
}

/// Robots on a line with cameras and tags, and a rock with tags.
std::string seeing_line() {
  std::string text;
  for (int i = 0; i < 4; ++i) {
    text += fmt::format(
        "[agent.r{0}]\nrobot = \"multirotor\"\nstart = {{ p = [{1}, 0.0, 1.0], heading = 0.0 }}\n"
        "sensor = {{ pitch = 0.0, offset = 0.1 }}\ntags = {{}}\n{2}\n",
        i, -1.6 * i, i < 3 ? "camera = {}" : "");
  }
  return text + "[obstacle.rock]\np = [2.0, 0.0, 1.0]\ntags = {}\n[obstacle.bare]\np = [9.0, 0.0, 1.0]\n";
}

std::string best_shape(std::string_view keys) {
  return fmt::format("[[shape]]\nname = \"who\"\nbest = {{ {} }}\npotential = {{ {} }}\n", keys,
                     sensor_cone_table);
}

TEST(ReadShape, TheBestObservesByPathsToWhatKnowsItsPlace) {
  const Scenario s = scenario_of(
      seeing_line() + best_shape("target = [\"rock\", \"r0\", \"r1\", \"r2\"], observers = [\"r0\", \"r1\", "
                                 "\"r2\"], observers_max = 1, margin = 0.02, dwell = 0.7, ramp = 0.4"));
  ASSERT_EQ(s.team.couplings().size(), 3U);
  const auto target = [&](std::size_t i) { return s.team.name(s.team.couplings()[i].between.second); };
  EXPECT_EQ(target(0), "rock");
  EXPECT_EQ(target(1), "r0");
  EXPECT_EQ(target(2), "r1");
  ASSERT_EQ(s.script.choices.size(), 1U);
  EXPECT_EQ(s.script.choices[0].at_most, 1);
  EXPECT_EQ(s.script.choices[0].margin, 0.02);
  EXPECT_EQ(s.script.choices[0].dwell, 0.7);
  EXPECT_EQ(s.script.events.size(), 12U);
  EXPECT_EQ(s.script.events[0].ramp, 0.4);
  EXPECT_NE(summary(s).find("observes"), std::string::npos);
  EXPECT_TRUE(changes_in_flight(s));
}

TEST(ReadShape, OneTargetHasOneObserverAtATime) {
  const Scenario s =
      scenario_of(seeing_line() + best_shape("target = \"rock\", observers = [\"r2\", \"r1\", \"r0\"]"));
  ASSERT_EQ(s.team.couplings().size(), 1U);
  EXPECT_EQ(s.team.name(s.team.couplings()[0].between.first), "r0");
}

TEST(ReadShape, ABestObserverThatCannotBeIsRefused) {
  const auto refused = [](std::string_view keys) {
    const std::string said = test::scenario_refusal(seeing_line() + best_shape(keys));
    return said.substr(std::min(said.size(), said.find("shape[0]")));
  };
  EXPECT_EQ(refused("target = \"rock\", observers = [\"r0\", \"r3\"]"),
            "shape[0].best.observers[1] = \"r3\", expected a robot with a camera, [agent.r3.camera]");
  EXPECT_EQ(refused("target = [\"rock\", \"bare\"], observers = [\"r0\"]"),
            "shape[0].best.target[1] = \"bare\", expected a body with tags, [obstacle.bare.tags]");
  EXPECT_EQ(refused("target = \"r0\", observers = [\"r0\", \"r1\"]"),
            "shape[0].best.observers[0] = \"r0\", expected a robot other than the target");
  EXPECT_EQ(refused("target = [\"r0\", \"r1\"], observers = [\"r0\", \"r1\"]"),
            "shape[0].best.target = [\"r0\", \"r1\"], expected a body that is no observer among them, since "
            "one has to "
            "know its place without looking");
  EXPECT_EQ(refused("target = \"rock\", observers = [\"rock\"]"),
            "shape[0].best.observers[0] = \"rock\", expected a robot other than the target");
  EXPECT_EQ(refused("target = \"rock\", observers = [\"r0\"], observers_max = 0"),
            "shape[0].best.observers_max = 0, expected an integer, 1 to 1024");
}

}  // namespace
}  // namespace sightline
