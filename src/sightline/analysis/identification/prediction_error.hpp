/// How far a model's predictions are from a flight.
#pragma once

#include <cstddef>

#include "sightline/analysis/identification/model_fit.hpp"

namespace sightline {

/// Over predictions of a second from every third period of a stretch on. Where the truth is known they begin in it and
/// are compared with it; else they begin in the state that half a second of measurements before is nearest to, and the
/// measurements' noise counts.
struct PredictionError {
  std::size_t predictions = 0;
  double r2 =
      0.0;  ///< 1 - |v - v_predicted|^2 / |change of v|^2 after 1 s, of the velocity in the plane of G
  double position = 0.0;      ///< in the plane after 1 s, RMS [m]
  double height = 0.0;        ///< after 1 s, RMS [m]
  double heading = 0.0;       ///< after 1 s, RMS [rad]
  double velocity = 0.0;      ///< in the plane after 1 s, RMS [m/s]
  double acceleration = 0.0;  ///< that is left in the plane over 0.1 s, of 99.9 % at most [m/s^2]
  bool of_truth = false;

  /// One number, to compare models by: position, height, velocity times 1 s and heading times 1 m together [m].
  double whole() const;
};

PredictionError prediction_error(const FlownMotion& motion, const Stretch& stretch,
                                 const ModelStructure& structure, const ModelNumbers& numbers);

}  // namespace sightline
