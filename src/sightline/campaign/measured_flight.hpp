/// A run of a campaign with the errors that `sightline tune` makes small, and their derivatives.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sightline/campaign/tune.hpp"
#include "sightline/loop.hpp"

namespace sightline {

/// A squared error of the samples from some time on.
struct SquaredError {
  TuneMeasure measure{};
  double from = 0.0;           ///< samples before this time do not count [s]
  BodyId robot{};              ///< the observer, or the robot with the reference
  std::vector<BodyId> bodies;  ///< that it depends on
  /// Its value at a time [s] and the Sights of all bodies.
  std::function<double(double, std::span<const Sight<double>>)> value;
};

/// The errors of all measures of a team that does not change.
std::vector<SquaredError> squared_errors(const ScenarioSpec& scenario);

/// A flown run.
struct MeasuredFlight {
  std::array<double, tune_measures.size()> squares{};  ///< mean squared error of each measure; NaN: none
  bool recovered = false;
  std::vector<double> x{};  ///< true states at the updates, one after another (K+1 x nx)
};

/// Flies one run as a campaign does.
MeasuredFlight fly_measured(const Scenario& run, const CampaignPlan& plan);

/// Derivatives of a flight's mean squared error.
struct MeasureGradient {
  std::vector<double> by_parameters;  ///< in the order of `names`
  std::vector<std::string> names;     ///< of InputGradient::parameters()
  int updates = 0, without_derivative = 0;
};

/// Differentiates along the flown states.
MeasureGradient differentiate(const Scenario& run, const MeasuredFlight& flight, TuneMeasure measure);

}  // namespace sightline
