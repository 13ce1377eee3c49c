/// Fits a model of a multirotor to its flight.
#pragma once

#include <cstddef>
#include <vector>

#include "sightline/analysis/identification/motion_prediction.hpp"

namespace sightline {

/// A part of a record, from the period `from` on up to `to`, which is not of it.
struct Stretch {
  std::size_t from = 0, to = 0;
};

/// A number as it was found.
struct FoundNumber {
  FittedNumber number;
  double value = 0.0;
  double interval = 0.0;  ///< half the width of its 95 % confidence interval
  bool moved = true;      ///< else its input rested, and the value is the one that the fit began with

  double low() const { return value - interval; }
  double high() const { return value + interval; }
  /// Whether the interval is at most a quarter of the value either way; of a lag or a delay also where it is at most 20 ms. What
  /// is of the flight need not be known.
  bool known() const;
};

struct FittedModel {
  ModelStructure structure;
  ModelNumbers numbers;
  std::vector<FoundNumber> found;
};

/// The numbers theta whose predictions come nearest to the measurements y, over windows w of a second that do not overlap,
///
///   min over theta, s_w of   sum over w, k of |y_k - prediction(theta, s_w)_k|^2 / sigma^2,    y = (p, psi, v_f, v_s)
///
/// by Gauss-Newton with the damping of Levenberg and Marquardt. Where each window begins, s_w, is estimated along with
/// theta and eliminated from each step, so that the noise of a measurement spoils no prediction. sigma, one of the
/// plane, the height, the heading and the velocity, is that of the residuals.
///
/// The intervals are the wider of two: those of independent residuals, and those of residuals that depend on each other
/// within a window (the sandwich estimator, clustered), as they do where the vehicle is none of the family.
FittedModel fit_model(const FlownMotion& motion, const Stretch& stretch, const ModelStructure& structure);
/// The delay that stands for the lags of a model as well: of the same model without lags, all other numbers as they are.
FittedModel fit_lumped(const FlownMotion& motion, const Stretch& stretch, const FittedModel& with_lags);

/// The state at period k that measurements of the periods k to k + samples are nearest to, by the model.
SeenMotion fitted_start(const FlownMotion& motion, const MotionPrediction& prediction, std::size_t k,
                        std::size_t samples);

/// Whether each input moved in a stretch, by more than a hundredth of its limit (standard deviation).
std::array<bool, 4> inputs_moved(const FlownMotion& motion, const Stretch& stretch);

}  // namespace sightline
