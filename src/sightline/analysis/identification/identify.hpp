/// Which model of a multirotor a flight shows, how well it is known, and how well it predicts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis/identification/excitation.hpp"
#include "sightline/analysis/identification/prediction_error.hpp"

namespace sightline {

struct Identification {
  /// A structure, fitted to the first part of the flight and judged on the rest.
  struct Candidate {
    ModelStructure structure;
    PredictionError error;
  };

  std::string robot, model;  ///< its name, and its kind in the scenario
  std::array<double, 4> u_max{};
  double seconds = 0.0;   ///< of flight
  double held_out = 0.0;  ///< of them that judge [s]
  std::vector<Candidate> candidates{};
  std::size_t chosen = 0;  ///< among them
  FittedModel best{};      ///< of that structure, fitted to all of the flight
  std::optional<FittedModel>
      lumped{};  ///< the same without lags, which its delay stands for; none where there are none
  std::vector<std::string> missing{};  ///< what the flight did not excite, sentences

  const PredictionError& error() const { return candidates[chosen].error; }
};

/// Fits every structure to all but the last quarter of a flight, at least 2 s, and judges it there. Chosen is the one
/// of the fewest numbers whose error is at most 3 % more than the least; of two under tilt commands the one with the
/// Coriolis term, which has no number. Of a flight that was measured between periods all have the delay: it is what the vehicle's own
/// periods, and the link, take.
/// @param kind  of the excitation, where it is known
/// @throws std::invalid_argument for a flight of less than 5 s, and for one without motion
Identification identify(const FlownMotion& motion, std::optional<ExcitationKind> kind = {});

}  // namespace sightline
