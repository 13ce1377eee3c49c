/// Fits a model of a multirotor to its flight.
#pragma once

#include <cstddef>
#include <vector>

#include "sightline/analysis/identification/motion_prediction.hpp"

namespace sightline {

/// A part of a record: periods [from, to).
struct Stretch {
  std::size_t from = 0, to = 0;
};

/// A fitted number.
struct FoundNumber {
  FittedNumber number;
  double value = 0.0;
  double interval = 0.0;  ///< half the width of its 95 % confidence interval
  bool moved = true;      ///< if false, its input was at rest and the value is the initial one

  double low() const { return value - interval; }
  double high() const { return value + interval; }
  /// Whether the interval is at most a quarter of |value|; for a lag or a delay, 20 ms suffices.
  /// Numbers of the flight always count as known.
  bool known() const;
};

struct FittedModel {
  ModelStructure structure;
  ModelNumbers numbers;
  std::vector<FoundNumber> found;
};

/// Least-squares estimate of the numbers theta from the measurements y, over non-overlapping
/// windows w of 1 s,
///
///   min over theta, s_w of   sum over w, k of |y_k - prediction(theta, s_w)_k|^2 / sigma^2,
///   y = (p, psi, v_f, v_s)
///
/// by Gauss-Newton with Levenberg-Marquardt damping. The initial state s_w of each window is
/// estimated together with theta and eliminated from each step, so that measurement noise does not
/// corrupt the predictions. sigma is the residuals' standard deviation, one each for the plane, the
/// height, the heading and the velocity.
///
/// Each interval is the wider of two: for independent residuals, and for residuals that are
/// correlated within a window (clustered sandwich estimator). The second one covers a vehicle
/// outside the family.
FittedModel fit_model(const FlownMotion& motion, const Stretch& stretch, const ModelStructure& structure);
/// Fits the delay of the model without lags, all other numbers fixed: a lumped delay that also
/// replaces the lags.
FittedModel fit_lumped(const FlownMotion& motion, const Stretch& stretch, const FittedModel& with_lags);

/// State at period k whose prediction fits the measurements of the periods k to k + samples best.
SeenMotion fitted_start(const FlownMotion& motion, const MotionPrediction& prediction, std::size_t k,
                        std::size_t samples);

/// Whether each input moved in a stretch: standard deviation above a hundredth of its limit.
std::array<bool, 4> inputs_moved(const FlownMotion& motion, const Stretch& stretch);

}  // namespace sightline
