#include "sightline/campaign/tune.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/campaign/measured_flight.hpp"
#include "sightline/campaign/weights.hpp"

namespace sightline {
namespace {

/// Logarithms of the factors of all weights.
using Factors = std::vector<double>;

/// Flown runs of one choice of weights.
struct FlownRuns {
  std::vector<Scenario> scenarios{};
  std::vector<MeasuredFlight> flights{};
  TuneRuns result{};
};

/// Derivatives of the logarithm of the measure.
struct Slope {
  Factors by_factors;
  int updates = 0, without_derivative = 0;
};

class Tuner {
 public:
  Tuner(const Scenario& scenario, const TuneOptions& options);

  TunedScenario tune(const std::function<void(std::string_view)>& report);

 private:
  template <class Work>
  void share(std::size_t parts, Work&& work);
  double written(std::size_t weight, double factor) const;
  std::string text(const Factors& factors) const;
  FlownRuns fly(const Factors& factors, int first, int runs);
  Slope slope(const FlownRuns& flown, const Factors& factors);
  double measure(const FlownRuns& flown) const { return flown.result.measures[place()]; }
  std::size_t place() const { return static_cast<std::size_t>(options_.measure); }
  bool is_better(const FlownRuns& candidate, const FlownRuns& than) const;

  const Scenario& scenario_;
  const CampaignPlan& plan_;
  TuneOptions options_;
  double bound_;  // of the logarithm of a factor
  ThreadPool pool_;
  std::vector<WeightInText> weights_;
};

void check_gives_derivatives(const Scenario& scenario) {
  const std::string& file = scenario.file.native();
  if (scenario.solver.name != "newton_riccati")
    throw_invalid("{}: solver.name = {}, expected newton_riccati, whose updates have derivatives", file,
                  scenario.solver.name);
  if (scenario.partition)
    throw_invalid("{}: [partition], expected one newton_riccati for the whole team", file);
  if (changes_in_flight(scenario))
    throw_invalid("{}: the team changes in flight, expected a team that stays", file);
  if (scenario.links) throw_invalid("{}: [fleet], expected a simulated team", file);
}

/// The robots that a measure judges.
std::vector<BodyId> judged_robots(const Scenario& scenario, const CampaignPlan& plan, TuneMeasure measure) {
  std::vector<BodyId> robots;
  double from = 0.0;
  for (const SquaredError& error : squared_errors(scenario)) {
    if (error.measure != measure) continue;
    robots.push_back(error.robot);
    from = error.from;
  }
  const std::string_view name = tune_measures[static_cast<std::size_t>(measure)];
  if (robots.empty()) {
    constexpr std::array<std::string_view, 3> expected = {"a coupling with a sensor",
                                                          "a coupling with a sensor and alpha",
                                                          "a robot whose Q weighs a position"};
    throw_invalid("{}: nothing has a {}, expected {}", scenario.file.native(), name,
                  expected[static_cast<std::size_t>(measure)]);
  }
  if (from >= plan.duration - scenario.horizon.dt)
    throw_invalid("{}: simulation.{} = {} s, expected less than campaign.duration = {} s",
                  scenario.file.native(), measure == TuneMeasure::rms_position_error ? "rms_from" : "settle",
                  from, plan.duration);
  return robots;
}

std::vector<std::string> drawn_keys(const CampaignPlan& plan) {
  std::vector<std::string> keys;
  for (const NumberDraw& draw : plan.draws) {
    keys.push_back(draw.key);
    for (const NumberDraw::Linked& linked : draw.also) keys.push_back(linked.key);
  }
  return keys;
}

Tuner::Tuner(const Scenario& scenario, const TuneOptions& options)
    : scenario_(scenario),
      plan_(campaign_plan(scenario)),
      options_(options),
      bound_(std::log(options.factor)),
      pool_(options.threads) {
  const std::string& file = scenario.file.native();
  check_gives_derivatives(scenario);
  if (drawn_names(plan_).empty())
    throw_invalid("{}: [campaign] draws nothing, expected [[campaign.start]] or [[campaign.draw]]", file);
  const std::vector<BodyId> robots = judged_robots(scenario, plan_, options.measure);
  weights_ = weights_of(scenario, robots, drawn_keys(plan_));
  if (weights_.empty())
    throw_invalid("{}: no weight acts on the robots that {} judges, expected one > 0 that no draw sets", file,
                  tune_measures[place()]);
}

/// Runs parts on all threads; the first exception of a part ends with this call.
template <class Work>
void Tuner::share(std::size_t parts, Work&& work) {
  std::vector<std::exception_ptr> failures(parts);
  pool_.share(static_cast<int>(parts), [&](int part, int) noexcept {
    try {
      work(at(part));
    } catch (...) {
      failures[at(part)] = std::current_exception();
    }
  });
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

/// A weight as it is flown and written: with four digits.
double Tuner::written(std::size_t weight, double factor) const {
  const double before = weights_[weight].number.value;
  return factor == 0 ? before : std::stod(fmt::format("{:.4g}", before * std::exp(factor)));
}

std::string Tuner::text(const Factors& factors) const {
  std::vector<std::pair<NumberInText, double>> changes;
  for (std::size_t i = 0; i < weights_.size(); ++i)
    if (factors[i] != 0) changes.emplace_back(weights_[i].number, written(i, factors[i]));
  return with_numbers(scenario_.text, changes);
}

FlownRuns Tuner::fly(const Factors& factors, int first, int runs) {
  Scenario tuned = scenario_;
  tuned.text = text(factors);
  const Variants variants(tuned, plan_);
  FlownRuns flown;
  flown.scenarios.resize(at(runs));
  flown.flights.resize(at(runs));
  share(at(runs), [&](std::size_t i) {
    Scenario run = variants.of(draw_run(plan_, options_.seed, first + static_cast<int>(i)));
    run.log.prediction_period = 0;
    flown.flights[i] = fly_measured(run, plan_);
    flown.scenarios[i] = std::move(run);
  });
  for (const MeasuredFlight& flight : flown.flights) {
    flown.result.recovered += flight.recovered ? 1 : 0;
    for (std::size_t m = 0; m < tune_measures.size(); ++m)
      flown.result.measures[m] += flight.squares[m] / static_cast<double>(runs);
  }
  for (double& mean : flown.result.measures) mean = std::sqrt(mean);
  return flown;
}

Slope Tuner::slope(const FlownRuns& flown, const Factors& factors) {
  std::vector<MeasureGradient> gradients(flown.flights.size());
  share(gradients.size(), [&](std::size_t i) {
    gradients[i] = differentiate(flown.scenarios[i], flown.flights[i], options_.measure);
  });
  Slope slope{Factors(weights_.size())};
  const double mean_square = square(measure(flown)), runs = static_cast<double>(gradients.size());
  for (const MeasureGradient& gradient : gradients) {
    std::map<std::string_view, double> by_name;
    for (std::size_t p = 0; p < gradient.names.size(); ++p)
      by_name[gradient.names[p]] = gradient.by_parameters[p];
    for (std::size_t i = 0; i < weights_.size(); ++i)
      for (const auto& [name, by_number] : weights_[i].slopes)
        slope.by_factors[i] +=
            by_name[name] * by_number * written(i, factors[i]) / (2.0 * runs * mean_square);
    slope.updates += gradient.updates;
    slope.without_derivative += gradient.without_derivative;
  }
  return slope;
}

bool Tuner::is_better(const FlownRuns& candidate, const FlownRuns& than) const {
  return candidate.result.recovered >= than.result.recovered && measure(candidate) < measure(than);
}

TunedScenario Tuner::tune(const std::function<void(std::string_view)>& report) {
  constexpr int tries = 6;              // step sizes along one direction
  constexpr double least_gain = 0.002;  // of the measure, relative: a smaller one ends the search
  const auto describe = [&](std::string_view when, const FlownRuns& flown) {
    if (report)
      report(fmt::format("{}: {} {:.4g} {}, {} of {} runs recovered", when, tune_measures[place()],
                         measure(flown), tune_units[place()], flown.result.recovered, options_.draws));
  };
  TunedScenario tuning;
  Factors factors(weights_.size());
  FlownRuns flown = fly(factors, 0, options_.draws);
  tuning.draws_before = flown.result;
  describe("before", flown);
  int updates = 0, without_derivative = 0;
  double step = std::log(2.0);
  for (int k = 0; k < options_.steps && measure(flown) > 0; ++k) {
    const Slope slope = this->slope(flown, factors);
    updates += slope.updates;
    without_derivative += slope.without_derivative;
    Factors direction(factors.size());
    double steepest = 0.0;
    for (std::size_t i = 0; i < factors.size(); ++i) {
      const double down = -slope.by_factors[i];
      if (!std::isfinite(down) || (down > 0 ? factors[i] >= bound_ : factors[i] <= -bound_)) continue;
      direction[i] = down;
      steepest = std::max(steepest, std::fabs(down));
    }
    if (steepest == 0) break;
    std::optional<FlownRuns> next;
    for (int t = 0; t < tries && !next; ++t, step /= 3.0) {
      Factors trial = factors;
      for (std::size_t i = 0; i < trial.size(); ++i)
        trial[i] = std::clamp(trial[i] + step * direction[i] / steepest, -bound_, bound_);
      FlownRuns candidate = fly(trial, 0, options_.draws);
      if (!is_better(candidate, flown)) continue;
      next = std::move(candidate);
      factors = std::move(trial);
      step *= 6.0;  // the division follows
    }
    if (!next) break;
    step = std::min(step, 2.0 * bound_);
    const double gain = 1.0 - measure(*next) / measure(flown);
    flown = std::move(*next);
    ++tuning.steps;
    describe(fmt::format("step {}", tuning.steps), flown);
    if (gain < least_gain) break;
  }
  tuning.draws_after = flown.result;
  tuning.without_derivative = updates > 0 ? static_cast<double>(without_derivative) / updates : 0.0;
  for (std::size_t i = 0; i < weights_.size(); ++i)
    tuning.weights.push_back({weights_[i].key, weights_[i].number.value, written(i, factors[i])});
  tuning.text = text(factors);

  const FlownRuns before = fly(Factors(weights_.size()), options_.draws, options_.held_out);
  const FlownRuns after = fly(factors, options_.draws, options_.held_out);
  tuning.held_out_before = before.result;
  tuning.held_out_after = after.result;
  tuning.accepted = tuning.steps > 0 && is_better(after, before);
  return tuning;
}

}  // namespace

TuneMeasure tune_measure(std::string_view name) {
  const auto found = std::find(tune_measures.begin(), tune_measures.end(), name);
  if (found == tune_measures.end())
    throw_invalid("--for = {}, expected one of {}", name, fmt::join(tune_measures, ", "));
  return static_cast<TuneMeasure>(found - tune_measures.begin());
}

void check_tune(const Scenario& scenario, const TuneOptions& options) { Tuner(scenario, options); }

TunedScenario tune(const Scenario& scenario, const TuneOptions& options,
                   const std::function<void(std::string_view)>& report) {
  return Tuner(scenario, options).tune(report);
}

std::string tuning_json(const TunedScenario& tuning, const Scenario& scenario, const TuneOptions& options) {
  using Json = nlohmann::ordered_json;
  const auto runs = [](const TuneRuns& result) {
    Json json;
    for (std::size_t m = 0; m < tune_measures.size(); ++m)
      json[std::string(tune_measures[m])] =
          std::isfinite(result.measures[m]) ? Json(result.measures[m]) : Json(nullptr);
    json["recovered"] = result.recovered;
    return json;
  };
  Json json = {
      {"scenario", scenario.name},
      {"measure", tune_measures[static_cast<std::size_t>(options.measure)]},
      {"seed", options.seed},
      {"factor", options.factor},
      {"steps", tuning.steps},
      {"accepted", tuning.accepted},
      {"without_derivative", tuning.without_derivative},
      {"draws",
       {{"runs", options.draws}, {"before", runs(tuning.draws_before)}, {"after", runs(tuning.draws_after)}}},
      {"held_out",
       {{"runs", options.held_out},
        {"before", runs(tuning.held_out_before)},
        {"after", runs(tuning.held_out_after)}}},
      {"weights", Json::array()}};
  for (const TunedWeight& weight : tuning.weights)
    json["weights"].push_back({{"key", weight.key}, {"before", weight.before}, {"after", weight.after}});
  return json_text(json, 2) + "\n";
}

}  // namespace sightline
