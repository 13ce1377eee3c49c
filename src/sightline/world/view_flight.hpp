/// Accuracy of a robot's vision localization by one body, as a function of their distance, from
/// simulated flights without a solver.
#pragma once

#include <cstdint>

#include "sightline/estimator.hpp"
#include "sightline/events.hpp"
#include "sightline/sensors.hpp"

namespace sightline {

/// An observer that keeps its distance from a body and observes it with its camera. The body flies
/// round a circle of 0.8 m radius and rotates. The observer keeps heading 0 and holds the body on
/// its optical axis, with a lag in position. Its filter receives the motion samples of
/// MotionSensor, and the detections of SyntheticDetections without latency. The body broadcasts its
/// pose.
struct ViewFlight {
  Camera camera{};
  SensorMount mount{};
  Tags tags{};
  FilterOptions filter{};
  double target_speed = 0.0;  ///< [m/s], >= 0
  double sway = 0.08;         ///< amplitude of the distance, as gusts and a solver cause it [m], >= 0
  double lag = 0.05;          ///< of the observer [s], >= 0
  double given_sigma = 0.01;  ///< of the pose that the body broadcasts [m], [rad], > 0
  double duration = 20.0;     ///< [s]; the figures exclude the first 4 s
  std::uint64_t seed = 1;

  bool operator==(const ViewFlight&) const = default;
  static constexpr double loss = 0.5;  ///< longest time without a detection before the view counts as lost
                                       ///< [s]
};

struct ViewFigures {
  double found = 0.0;  ///< share of the pictures with a detection of the body
  double known = 0.0;  ///< share of the time with an estimate
  double sigma =
      0.0;  ///< root mean square of PoseEstimate::position_sigma(); infinite without any estimate [m]
  double error = 0.0;   ///< root mean square of the position error; infinite without any estimate [m]
  double losses = 0.0;  ///< losses of view per minute
  double lost = 0.0;    ///< share of the time with the view lost
};

/// Flies once at a distance of the two bodies' origins [m], > 0.
ViewFigures fly_beside(const ViewFlight& flight, double distance);

/// Means over several flights with consecutive seeds from flight.seed; root mean square for sigma
/// and error.
/// @param fly  (ViewFlight, distance) -> ViewFigures
template <class Fly>
ViewFigures mean_figures(ViewFlight flight, double distance, int flights, Fly&& fly) {
  ViewFigures mean;
  for (int i = 0; i < flights; ++i, ++flight.seed) {
    const ViewFigures one = fly(flight, distance);
    mean.found += one.found / flights, mean.known += one.known / flights, mean.lost += one.lost / flights;
    mean.losses += one.losses / flights;
    mean.error += square(one.error) / flights, mean.sigma += square(one.sigma) / flights;
  }
  mean.error = sqrt(mean.error), mean.sigma = sqrt(mean.sigma);
  return mean;
}
inline ViewFigures mean_figures(const ViewFlight& flight, double distance, int flights) {
  return mean_figures(flight, distance, flights, fly_beside);
}

/// sigma^2 over the distance, up to the first one where less than half of the pictures show the
/// body. Distances that are too short for a detection have the value of the nearest one with
/// detections.
ViewVariance view_variance(const ViewFlight& flight);

}  // namespace sightline
