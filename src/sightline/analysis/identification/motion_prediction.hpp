/// How a flight goes on from any of its periods, by a model of the vehicle and the commands that were given.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sightline/analysis/identification/flown_motion.hpp"
#include "sightline/analysis/identification/model_family.hpp"

namespace sightline {

/// Tilt, climb and yaw rate follow from the commands of the whole record, at rest before it; after `forgotten` seconds
/// nothing is left of how it began. A delay is any time >= 0: a step takes the mean of the delayed commands, from their
/// integral, so a prediction moves smoothly with it.
class MotionPrediction {
 public:
  static constexpr double forgotten = 0.6;  // [s]

  /// @param motion  outlives this
  MotionPrediction(const FlownMotion& motion, const ModelStructure& structure, const ModelNumbers& numbers);

  /// From `start` at period k on: gives seen(j, motion) for each period k + j, j = 0 ... samples.
  template <class Seen>
  void run(std::size_t k, std::size_t samples, SeenMotion start, Seen&& seen) const {
    seen(std::size_t{0}, start);
    for (std::size_t j = 0; j < samples; ++j) {
      for (std::size_t q = 0; q < parts_; ++q) step(forced_[(k + j) * parts_ + q], start);
      seen(j + 1, start);
    }
  }

 private:
  /// Means over a step that the motion in the plane does not change.
  struct Forced {
    double push_f, push_s, climb, rate;
  };
  void step(const Forced& forced, SeenMotion& m) const;

  ModelStructure structure_;
  double a_f_, a_s_;
  Vec2<double> wind_;  // acceleration in G [m/s^2]
  std::size_t parts_;  // steps of a period
  double h_;           // of a step [s]
  std::vector<Forced> forced_;
};

}  // namespace sightline
