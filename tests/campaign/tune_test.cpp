// Weights that are adjusted over draws: descent of the measure, and what may choose them.
#include "sightline/campaign/tune.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sightline/campaign/measured_flight.hpp"
#include "sightline/campaign/weights.hpp"
#include "sightline/scenario/toml_table.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

Scenario short_runs(const std::vector<std::string>& further = {}) {
  std::vector<std::string> set = {"campaign.duration=3.0", "simulation.settle=0.5",
                                  "simulation.rms_from=0.5"};
  set.insert(set.end(), further.begin(), further.end());
  return read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_2.toml", built_in_registry(), set);
}

TuneOptions few(TuneMeasure measure, int steps = 2) {
  return {.measure = measure, .draws = 2, .held_out = 2, .steps = steps, .threads = 2};
}

double of(const TuneRuns& runs, TuneMeasure measure) {
  return runs.measures[static_cast<std::size_t>(measure)];
}

ScenarioNumbers numbers_in(const std::string& text) { return numbers_of(parse_toml(text, "a.toml")); }

TEST(Tune, EveryStepLowersTheMeasureOfTheDraws) {
  const Scenario scenario = short_runs();
  for (const TuneMeasure measure : {TuneMeasure::view_angle, TuneMeasure::rms_position_error}) {
    const TunedScenario one = tune(scenario, few(measure, 1)), three = tune(scenario, few(measure, 3));
    EXPECT_LT(of(one.draws_after, measure), of(one.draws_before, measure));
    EXPECT_LT(of(three.draws_after, measure), of(one.draws_after, measure));
    EXPECT_EQ(of(three.draws_before, measure), of(one.draws_before, measure));
    EXPECT_LT(one.without_derivative, 0.1);
  }
}

TEST(Tune, OneSeedGivesOneResultWhateverTheNumberOfThreads) {
  const Scenario scenario = short_runs();
  TuneOptions options = few(TuneMeasure::view_angle);
  const std::string two = tuning_json(tune(scenario, options), scenario, options);
  options.threads = 1;
  EXPECT_EQ(tuning_json(tune(scenario, options), scenario, options), two);
  options.seed = 2;
  EXPECT_NE(tuning_json(tune(scenario, options), scenario, options), two);
}

TEST(Tune, HeldOutRunsChooseNothing) {
  const Scenario scenario = short_runs();
  TuneOptions options = few(TuneMeasure::view_angle);
  const TunedScenario two = tune(scenario, options);
  options.held_out = 3;
  const TunedScenario three = tune(scenario, options);
  EXPECT_EQ(three.text, two.text);
  EXPECT_EQ(three.draws_after.measures, two.draws_after.measures);
  EXPECT_NE(three.held_out_after.measures, two.held_out_after.measures);
}

TEST(Tune, ChangesWeightsAloneWithinTheFactorAndFliesWhatItWrites) {
  const Scenario scenario = short_runs();
  TuneOptions options = few(TuneMeasure::rms_position_error, 4);
  options.factor = 1.5;
  const TunedScenario tuning = tune(scenario, options);
  std::map<std::string, double> changed;
  for (const TunedWeight& weight : tuning.weights) {
    changed[weight.key] = weight.after;
    EXPECT_THAT(weight.key, testing::StartsWith("agent.uav1."));  // uav0 tracks no position
    EXPECT_LE(std::fabs(std::log(weight.after / weight.before)), std::log(1.5) + 1e-3) << weight.key;
  }
  const ScenarioNumbers before = numbers_in(scenario.text), after = numbers_in(tuning.text);
  ASSERT_EQ(before.size(), after.size());
  for (const auto& [key, number] : after)
    EXPECT_EQ(number.value, changed.contains(key) ? changed[key] : before.at(key).value) << key;

  const Scenario tuned = parse_scenario(tuning.text, scenario.file);
  options.steps = 1;
  EXPECT_EQ(tune(tuned, options).held_out_before.measures, tuning.held_out_after.measures);
}

TEST(Tune, DerivativesOfAMeasureAreDifferencesOfFlights) {
  // Without noise, and with the optimum in each update, flights differ by the weights alone.
  const std::vector<std::string> calm = {"simulation.disturbance.noise.position=0.0",
                                         "simulation.disturbance.noise.heading=0.0",
                                         "solver.max_newton_steps=20",
                                         "solver.tolerance=1e-9",
                                         "solver.max_krylov=30",
                                         "solver.krylov_stop=1e-8"};
  const auto flown = [&](std::vector<std::string> set) {
    set.insert(set.end(), calm.begin(), calm.end());
    const Scenario scenario = short_runs(set);
    return Variants(scenario, *scenario.campaign).of(draw_run(*scenario.campaign, 1, 0));
  };
  const Scenario run = flown({});
  for (const TuneMeasure measure : {TuneMeasure::view_angle, TuneMeasure::rms_position_error}) {
    const MeasureGradient gradient = differentiate(run, fly_measured(run, *run.campaign), measure);
    const bool view = measure == TuneMeasure::view_angle;
    for (const std::string& name : view ? std::vector<std::string>{"couple[0].weight", "couple[1].weight"}
                                        : std::vector<std::string>{"uav1.Q[0]", "uav1.R[1]"}) {
      const auto place = std::find(gradient.names.begin(), gradient.names.end(), name);
      ASSERT_NE(place, gradient.names.end()) << name;
      const double exact = gradient.by_parameters[static_cast<std::size_t>(place - gradient.names.begin())];
      const double here = name == "uav1.Q[0]" ? 1.5 : view ? 0.4 : 1.0, step = 1e-3 * here;
      const std::string key = view ? name : "agent." + name;
      const auto square_at = [&](double weight) {
        const Scenario other = flown({fmt::format("{}={}", key, weight)});
        return fly_measured(other, *other.campaign).squares[static_cast<std::size_t>(measure)];
      };
      const double measured = (square_at(here + step) - square_at(here - step)) / (2 * step);
      EXPECT_NEAR(exact, measured, 0.05 * std::fabs(measured)) << name;
      EXPECT_NE(measured, 0.0) << name;
    }
  }
}

TEST(Tune, AWeightOfATemplateActsOnAllThatHaveIt) {
  const Scenario scenario = parse_scenario(
      "[template.drone]\nrobot = \"multirotor\"\n"
      "Q = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]\nR = [1.0, 1.0, 1.0, 1.0]\n"
      "[agent.a]\ninherits = \"drone\"\nstart = { p = [0.0, 0.0, 1.0] }\n"
      "[agent.b]\ninherits = \"drone\"\nstart = { p = [3.0, 0.0, 1.0] }\n",
      "a.toml");
  const std::vector<BodyId> second = {BodyId{1}};
  const std::vector<std::string> none;
  const std::vector<WeightInText> weights = weights_of(scenario, second, none);
  ASSERT_EQ(weights.size(), 7U);  // three of Q, four of R
  for (const WeightInText& weight : weights) {
    ASSERT_EQ(weight.slopes.size(), 2U) << weight.key;
    for (const auto& [name, slope] : weight.slopes) EXPECT_NEAR(slope, 1.0, 1e-12) << name;
  }
  const std::vector<std::string> drawn = {weights.front().key};
  EXPECT_EQ(weights_of(scenario, second, drawn).size(), 6U);
}

TEST(Tune, RefusesWhatItCannotTune) {
  const auto refused = [](const Scenario& scenario, TuneMeasure measure = TuneMeasure::view_angle) {
    return refusal_of<std::exception>([&] { (void)tune(scenario, few(measure)); });
  };
  EXPECT_THAT(refused(short_runs({"solver={ name = \"cgmres\" }"})),
              HasSubstr("solver.name = cgmres, expected newton_riccati, whose updates have derivatives"));
  EXPECT_THAT(refused(short_runs({"simulation.settle=3.0"})),
              HasSubstr("simulation.settle = 3 s, expected less than campaign.duration = 3 s"));
  Scenario still = short_runs();
  still.campaign->starts.clear(), still.campaign->draws.clear();
  EXPECT_THAT(refused(still),
              HasSubstr("[campaign] draws nothing, expected [[campaign.start]] or [[campaign.draw]]"));
  Scenario without = short_runs();
  without.campaign.reset();
  EXPECT_THAT(refused(without), HasSubstr("campaign is missing"));
  EXPECT_THAT(refused(short_runs({"agent.uav1.Q=[0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]"}),
                      TuneMeasure::rms_position_error),
              HasSubstr("nothing has a rms_position_error, expected a robot whose Q weighs a position"));
  EXPECT_THAT(refusal_of([] { (void)tune_measure("view"); }),
              HasSubstr("--for = view, expected one of view_angle, view_excess, rms_position_error"));
}

}  // namespace
}  // namespace sightline
