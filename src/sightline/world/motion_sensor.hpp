/// What a robot's autopilot tells of its motion, in simulation.
#pragma once

#include <cstdint>

#include "sightline/base/no_value.hpp"
#include "sightline/estimate/filter_options.hpp"
#include "sightline/estimate/place.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline {

/// Motion samples of a robot from its true poses, with the errors that FilterOptions describe: white noise, and
/// biases that are drawn at the start and go on as Gauss-Markov processes or random walks.
class MotionSensor {
 public:
  /// @param errors  of the autopilot's sensors
  /// @throws std::invalid_argument from FilterOptions::check()
  MotionSensor(const FilterOptions& errors, std::uint64_t seed, int body);

  /// The robot was so at t, and moved on from the pose before, dt [s] earlier. The sample before must have ended
  /// there, for the specific force; the first one supposes the velocity at its beginning to be that over the
  /// period.
  /// @param R  attitude, B to G
  MotionSample measure(double t, double dt, const Vec3<double>& p_before, const Mat<3, 3>& R_before,
                       const Vec3<double>& p, const Mat<3, 3>& R) noexcept;

  /// The robot begins elsewhere: the next sample is a first one.
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
  double next_compass_ = -infinity;  // it is due at [s]
};

}  // namespace sightline
