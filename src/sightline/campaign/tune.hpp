/// Adjusts weights of a scenario by derivatives of its closed loop over a campaign's draws.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/analysis.hpp"

namespace sightline {

/// What is made small: a root mean square over the samples of all runs.
enum class TuneMeasure : std::uint8_t {
  view_angle,          ///< view angles of all observations, after settle [rad], (71)
  view_excess,         ///< their parts beyond alpha [rad]
  rms_position_error,  ///< distances from the references that Q weighs, from rms_from on [m]
};
inline constexpr std::array<std::string_view, 3> tune_measures = {"view_angle", "view_excess",
                                                                  "rms_position_error"};
inline constexpr std::array<std::string_view, 3> tune_units = {"rad", "rad", "m"};

/// @throws std::invalid_argument for another name than those of tune_measures
TuneMeasure tune_measure(std::string_view name);

struct TuneOptions {
  TuneMeasure measure = TuneMeasure::view_angle;
  int draws = 8;           ///< runs by which weights are chosen, from index 0 on; >= 1
  int held_out = 8;        ///< the next runs, by which the weights are accepted; >= 1
  int steps = 20;          ///< at most, >= 1
  double factor = 10.0;    ///< greatest change of a weight, > 1
  std::uint64_t seed = 1;  ///< of the draws
  int threads = 1;         ///< 1 to ThreadPool::most; the result does not depend on it
};

/// Some runs of one scenario.
struct TuneRuns {
  std::array<double, tune_measures.size()> measures{};  ///< NaN: nothing to judge
  int recovered = 0;                                    ///< runs with Outcome::recovered
};

struct TunedWeight {
  std::string key;  ///< as in error messages: "couple[0].weight"
  double before = 0.0, after = 0.0;
};

struct TunedScenario {
  std::vector<TunedWeight> weights{};  ///< all that may change
  std::string text{};                  ///< of the scenario with these weights
  TuneRuns draws_before{}, draws_after{}, held_out_before{}, held_out_after{};
  /// The measure of the held-out runs is smaller than before, and no fewer of them recovered.
  bool accepted = false;
  int steps = 0;                    ///< that lowered the measure
  double without_derivative = 0.0;  ///< share of the updates
};

/// @throws ScenarioError or std::invalid_argument if the scenario cannot be tuned for the measure
void check_tune(const Scenario& scenario, const TuneOptions& options);

/// Minimises a measure over the weights > 0 that act on the robots that it judges: observers for
/// views, robots with a weighted reference for errors.
///
/// The runs are those of `sightline campaign`, with all disturbances. Each step takes the derivatives
/// of the mean square along the flown states (LoopGradient::follow) by the logarithms of the
/// weights, and searches along the steepest descent, within `factor` of the scenario's weights. A
/// step is taken if the measure falls and no fewer runs recover. The held-out runs are flown before
/// and after, and choose nothing.
/// @param report  receives a sentence for each step
/// @throws as check_tune(), and ScenarioError if a drawn number or a weight is refused
TunedScenario tune(const Scenario& scenario, const TuneOptions& options,
                   const std::function<void(std::string_view)>& report = {});

/// tune.json of a tuning.
std::string tuning_json(const TunedScenario& tuning, const Scenario& scenario, const TuneOptions& options);

}  // namespace sightline
