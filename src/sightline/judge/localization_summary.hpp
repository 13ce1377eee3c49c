/// Accuracy of the poses of vision-localized robots.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sightline/judge.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Error of a pose estimate.
struct PoseError {
  Vec3<double> p{};   ///< truth minus estimate [m]
  double psi = 0.0;   ///< [rad], in [-pi, pi]
  double nees = 0.0;  ///< e^T P^-1 e of position and heading [-]
};
PoseError error_of(const PoseEstimate& estimate, const Vec3<double>& p, double psi) noexcept;

/// Collects RobotLocalization from samples. One thread; add() allocates nothing.
class LocalizationSummary {
 public:
  explicit LocalizationSummary(const Scenario& scenario);

  void add(const Sample& sample) noexcept;
  /// In the order of the scenario; empty if no robot is vision-localized.
  std::vector<RobotLocalization> robots() const;
  /// JSON list of objects; empty string if no robot is vision-localized.
  std::string json() const;

 private:
  struct Robot {
    BodyId body{};
    double known_from, seen, unseen = 0.0;  // seen: stamp of the last accepted detection [s]
    double squares = 0.0, heading_squares = 0.0, nees = 0.0, sigma_max = 0.0;
    std::int64_t errors = 0, detections = 0, rejected = 0, restarts = 0;
  };
  void add_estimate(Robot& robot, const Sample& sample) noexcept;

  Team team_;
  double settle_;  // [s]
  std::vector<Robot> robots_;
};

}  // namespace sightline
