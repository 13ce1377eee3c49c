/// Simulated motion samples of a robot's autopilot.
#pragma once

#include <cstdint>

#include "sightline/base/no_value.hpp"
#include "sightline/estimate/filter_options.hpp"
#include "sightline/estimate/place.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline {

/// Motion samples of a robot from its true poses, with the errors of FilterOptions: white noise and
/// biases. The biases are drawn at the start and continue as Gauss-Markov processes or random
/// walks.
class MotionSensor {
 public:
  /// @param errors  of the autopilot's sensors
  /// @throws std::invalid_argument from FilterOptions::check()
  MotionSensor(const FilterOptions& errors, std::uint64_t seed, int body);

  /// Measures the motion of the dt [s] up to t [s], from the previous pose to this one. The
  /// specific force needs the preceding sample to end at the previous pose. For the first sample
  /// the acceleration is taken as 0.
  /// @param R  attitude, B to G
  MotionSample measure(double t, double dt, const Vec3<double>& p_before, const Mat<3, 3>& R_before,
                       const Vec3<double>& p, const Mat<3, 3>& R) noexcept;

  /// The robot restarts elsewhere: the next sample counts as the first.
  void forget() noexcept { moved_ = false; }

 private:
  FilterOptions errors_;
  RandomStream chance_;
  Vec3<double> velocity_bias_, gyro_bias_, force_bias_;
  double yaw_rate_bias_;
  Vec2<double> tilt_error_;
  Vec3<double> v_before_{};
  bool moved_ = false;
  RandomStream magnetic_;
  double next_compass_ = -infinity;  // time of the next compass measurement [s]
};

}  // namespace sightline
