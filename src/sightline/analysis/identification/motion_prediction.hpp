/// Predicts a flight from any of its periods, by a model of the vehicle and the recorded commands.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sightline/analysis/identification/flown_motion.hpp"
#include "sightline/analysis/identification/model_family.hpp"

namespace sightline {

/// Tilt, climb and yaw rate follow from the commands of the whole record, from rest before it.
/// After `forgotten` seconds this initial state has no effect. A delay is any time >= 0: a step
/// uses the mean of the delayed commands, from their integral, so a prediction is continuous in the
/// delay.
class MotionPrediction {
 public:
  static constexpr double forgotten = 0.6;  // [s]

  /// @param motion  must outlive this object
  MotionPrediction(const FlownMotion& motion, const ModelStructure& structure, const ModelNumbers& numbers);

  /// Predicts from the state `start` at period k: calls seen(j, motion) for the periods k + j, j =
  /// 0 ... samples.
  template <class Seen>
  void run(std::size_t k, std::size_t samples, SeenMotion start, Seen&& seen) const {
    seen(std::size_t{0}, start);
    for (std::size_t j = 0; j < samples; ++j) {
      for (std::size_t q = 0; q < parts_; ++q) step(forced_[(k + j) * parts_ + q], start);
      seen(j + 1, start);
    }
  }

 private:
  /// Means over a step of the quantities that do not depend on the motion in the plane.
  struct Forced {
    double push_f, push_s, climb, rate;
  };
  void step(const Forced& forced, SeenMotion& m) const;

  ModelStructure structure_;
  double a_f_, a_s_;
  Vec2<double> wind_;  // acceleration in G [m/s^2]
  std::size_t parts_;  // steps per period
  double h_;           // length of a step [s]
  std::vector<Forced> forced_;
};

}  // namespace sightline
