/// Error of a model's predictions of a flight.
#pragma once

#include <cstddef>

#include "sightline/analysis/identification/model_fit.hpp"

namespace sightline {

/// Errors of predictions over 1 s from every third period of a stretch on. If the truth is known,
/// predictions start from it and are compared with it. Otherwise they start from the best fit to
/// the preceding half second of measurements, and the error includes the measurement noise.
struct PredictionError {
  std::size_t predictions = 0;
  double r2 =
      0.0;  ///< 1 - |v - v_predicted|^2 / |change of v|^2 after 1 s, of the velocity in the plane of G
  double position = 0.0;      ///< in the plane after 1 s, RMS [m]
  double height = 0.0;        ///< after 1 s, RMS [m]
  double heading = 0.0;       ///< after 1 s, RMS [rad]
  double velocity = 0.0;      ///< in the plane after 1 s, RMS [m/s]
  double acceleration = 0.0;  ///< remaining in the plane over 0.1 s, 99.9 % quantile [m/s^2]
  bool of_truth = false;

  /// Root of the sum of squares of position, height, velocity times 1 s and heading times 1 m [m];
  /// one number to compare models.
  double whole() const;
};

PredictionError prediction_error(const FlownMotion& motion, const Stretch& stretch,
                                 const ModelStructure& structure, const ModelNumbers& numbers);

}  // namespace sightline
