/// How well a robot that sees one body knows its place by it, over their distance: flights beside it, without a solver.
#pragma once

#include <cstdint>

#include "sightline/estimate/filter_options.hpp"
#include "sightline/ocp/view_choice.hpp"
#include "sightline/world/camera.hpp"

namespace sightline {

/// An observer that keeps its distance from a body and looks at it. The body flies round a circle of 0.8 m and turns; the observer
/// stays in the line of its optical axis, and follows place and direction by so much later. Its filter gets the motion
/// samples of MotionSensor, and the detections of SyntheticDetections when they are taken. The body tells its pose.
struct ViewFlight {
  Camera camera{};
  SensorMount mount{};
  Tags tags{};
  FilterOptions filter{};
  double target_speed = 0.0;  ///< [m/s], >= 0
  double sway = 0.08;  ///< by which the distance goes to and fro, as gusts and a solver leave it [m], >= 0
  double lag = 0.05;   ///< of the observer [s], >= 0
  double given_sigma = 0.01;  ///< of the pose that the body tells [m], [rad], > 0
  double duration = 20.0;     ///< [s]; figures are from 4 s on
  std::uint64_t seed = 1;

  bool operator==(const ViewFlight&) const = default;
  static constexpr double loss = 0.5;  ///< without a detection for longer than this, the view is lost [s]
};

struct ViewFigures {
  double found = 0.0;  ///< share of the pictures in which the body was found
  double known = 0.0;  ///< share of the time in which there was an estimate
  double sigma =
      0.0;  ///< root mean square of PoseEstimate::position_sigma(); infinite where it is never known [m]
  double error = 0.0;   ///< root mean square of the position's error [m]
  double losses = 0.0;  ///< in a minute
  double lost = 0.0;    ///< share of the time
};

/// At a distance of the two bodies' origins [m], > 0.
ViewFigures fly_beside(const ViewFlight& flight, double distance);

/// Means of several flights, of the seeds that follow flight.seed; of errors the root of the mean square.
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

/// sigma^2 over the distance, up to where less than half of the pictures show the body. Where it is too near to be seen, as at the
/// nearest distance at which it is.
ViewVariance view_variance(const ViewFlight& flight);

}  // namespace sightline
