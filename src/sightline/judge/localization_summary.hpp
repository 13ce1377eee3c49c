/// How well robots that are localized by view knew where they were.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// What is wrong with an estimate.
struct PoseError {
  Vec3<double> p{};   ///< truth less estimate [m]
  double psi = 0.0;   ///< [rad], in [-pi, pi]
  double nees = 0.0;  ///< e^T P^-1 e of both
};
PoseError error_of(const PoseEstimate& estimate, const Vec3<double>& p, double psi) noexcept;

/// Of one robot; not a number: there was nothing to compute it from, as errors where nobody knows the truth.
struct RobotLocalization {
  std::string name;
  double known_from;             ///< first estimate [s]
  double rmse, heading_rmse;     ///< of the estimate, after settle [m], [rad]
  double anees;                  ///< mean of e^T P^-1 e of position and heading, after settle; 4 is right
  double sigma_max;              ///< greatest standard deviation of the position, after settle [m]
  std::int64_t detections = 0;   ///< that were judged
  std::int64_t rejected = 0;     ///< of them, beyond the gate
  std::int64_t restarts = 0;     ///< the estimate began anew
  double longest_without_sight;  ///< between two detections that were believed [s]
};

/// Gathers it from samples. One thread; add() allocates nothing.
class LocalizationSummary {
 public:
  explicit LocalizationSummary(const Scenario& scenario);

  void add(const Sample& sample) noexcept;
  /// In the order of the scenario; none where nobody is localized by view.
  std::vector<RobotLocalization> robots() const;
  /// A list of objects; empty where nobody is.
  std::string json() const;

 private:
  struct Robot {
    BodyId body{};
    double known_from, seen, unseen = 0.0;  // seen: the last detection that was believed [s]
    double squares = 0.0, heading_squares = 0.0, nees = 0.0, sigma_max = 0.0;
    std::int64_t errors = 0, detections = 0, rejected = 0, restarts = 0;
  };
  void add_estimate(Robot& robot, const Sample& sample) noexcept;

  Team team_;
  double settle_;  // [s]
  std::vector<Robot> robots_;
};

}  // namespace sightline
