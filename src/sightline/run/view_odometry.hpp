/// The frame in which the certified view of a robot that is localized by vision is kept.
///
/// The frame O moves with the corrections of the pose filter, so that none of them moves the robot in it:
/// the robot's heading and height in O follow the estimated yaw rate and vertical velocity alone. The
/// horizontal position in O is that of a SlowState. In O only the errors of velocity and yaw rate
/// move a target that is at rest (docs/certified_view.md).
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/estimator.hpp"
#include "sightline/model.hpp"
#include "sightline/safety/view_certificate.hpp"

namespace sightline {

class OdometryFrame {
 public:
  /// @param model  its velocity is a state along its heading
  OdometryFrame(const Model& model, const ViewTask& task);

  const ViewOdometry& limits() const noexcept { return limits_; }

  /// O is G from this estimate on.
  void begin(const PoseEstimate& pose) noexcept;
  /// Moves O by the corrections since the previous estimate.
  void follow(const PoseEstimate& pose) noexcept;
  /// The robot's state in O (nx), valid until the next call. Its horizontal position is that in G.
  /// @param now  state at the time of the estimate (nx); `velocity` replaces its velocity
  /// @param later  state where the command takes effect (nx), predicted from `now`
  std::span<const double> carry(const PoseEstimate& pose, std::span<const double> now,
                                std::span<const double> later) noexcept;
  /// A body's position in O [m].
  /// @param p  position in G [m]
  /// @param slow  horizontal position of the robot in O [m], after carry()
  Vec3<double> place(const Vec3<double>& p, const Vec2<double>& slow) const noexcept;

 private:
  Model model_;
  ViewOdometry limits_;
  bool is_level_;
  double keeps_, moves_;  // of a velocity after the delay, and way per velocity [s]
  std::array<int, 3> position_;
  std::array<int, 2> direction_, velocity_V_;
  int angle_;
  PoseEstimate last_{};
  double turn_ = 0.0, lift_ = 0.0;  // from G to O [rad], [m]
  Vec2<double> own_{};              // horizontal position of the last carry() in G [m]
  std::vector<double> x_, no_inputs_;
};

/// Standard deviation of a body's estimated position relative to the robot, in the frame of its heading,
/// root of the sum over the axes [m]: by the joint covariance of position and heading, so that a
/// turn of the whole estimate about the body counts nothing.
double relative_sigma(const PoseEstimate& robot, const Vec3<double>& body) noexcept;

}  // namespace sightline
