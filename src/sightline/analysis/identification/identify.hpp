/// Selects the model of a multirotor that fits a flight, with confidence intervals and prediction
/// error.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis/identification/excitation.hpp"
#include "sightline/analysis/identification/prediction_error.hpp"

namespace sightline {

struct Identification {
  /// A structure, fitted to the first part of the flight and evaluated on the rest.
  struct Candidate {
    ModelStructure structure;
    PredictionError error;
  };

  std::string robot, model;  ///< name of the robot, and its kind in the scenario
  std::array<double, 4> u_max{};
  double seconds = 0.0;   ///< length of the flight
  double held_out = 0.0;  ///< part of the flight for the evaluation [s]
  std::vector<Candidate> candidates{};
  std::size_t chosen = 0;  ///< index in `candidates`
  FittedModel best{};      ///< of the chosen structure, fitted to the whole flight
  std::optional<FittedModel>
      lumped{};  ///< the same without lags, with a lumped delay; none for a model without lags
  std::vector<std::string> missing{};  ///< inputs that were not excited enough, a sentence each

  const PredictionError& error() const { return candidates[chosen].error; }
};

/// Fits every structure to all but the last quarter of a flight (at least 2 s) and evaluates it on
/// that quarter. Chooses the structure with the fewest numbers among errors of at most 1.03 times
/// the least one. Between two such structures under tilt commands it prefers the Coriolis term,
/// which has no number of its own. If the flight was measured between periods, all structures have
/// the delay, which covers the vehicle's own periods and the link.
/// @param kind  of the excitation, if known
/// @throws std::invalid_argument for a flight of less than 5 s, for one with too few measurements,
///   and for one without motion
Identification identify(const FlownMotion& motion, std::optional<ExcitationKind> kind = {});

}  // namespace sightline
