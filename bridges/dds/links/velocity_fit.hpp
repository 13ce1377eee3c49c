/// Velocity estimate of a body from its poses.
#pragma once

#include <array>
#include <optional>

#include "bridges/dds/topics/conversion.hpp"

namespace sightline::dds {

/// Velocity and heading rate from stamped poses: the slope at the newest pose of the least-squares
/// parabola through the last poses, for each of x, y, z and heading.
///
///   poses     of the last 0.1 s, more if these are fewer than 4; none older than 0.4 s, at most 64
///   lag       none at constant acceleration; at 100 Hz a sine of 1 Hz comes 1.4 ms late with a
///             gain of 1.04, one of 3 Hz 9 ms late with 1.25
///   noise     poses with standard deviation s give velocities with 35 s / (1 s) at 100 Hz:
///             0.3 mm give 0.011 m/s
///   stamps    any spacing: lost poses leave a longer gap, transport jitter has no effect
///   rejected  a pose more than 0.05 m + 25 m/s^2 dt^2 or 0.5 rad + 50 rad/s^2 dt^2 off the
///             parabola, up to twice in a row. The third restarts the fit, as does a pose after a
///             gap of 0.5 s. Before the first parabola, a position may be off by another 10 m/s dt
///
/// Single thread; allocates and throws nothing.
class VelocityFit {
 public:
  static constexpr std::size_t least = 4, most = 64;
  static constexpr Nanoseconds window = 100'000'000, longest = 400'000'000, silence = 500'000'000;
  static constexpr Nanoseconds densest = 2'000'000;  ///< closer poses count once
  static constexpr double gate_p = 0.05, gate_v = 10.0, gate_a = 25.0, gate_turn = 0.5, gate_turn_a = 50.0;
  static constexpr int most_outside = 2;

  enum class Outcome { good, too_few, jump };

  /// Accepts a finite pose with its stamp by the sender's clock. A body without heading has q =
  /// no_attitude.
  /// @param stamp   newer than the last, as RemoteClock accepts them
  /// @param motion  set completely if the outcome is good
  Outcome take(const Vec3<double>& p, const Quaternion& q, Nanoseconds stamp, Motion& motion) noexcept;

 private:
  using Values = std::array<double, 4>;  // x, y, z [m], heading [rad], unwrapped beyond pi
  struct Pose {
    Nanoseconds stamp = 0;
    Values at{};
  };
  const Pose& pose(std::size_t back) const noexcept { return poses_[(next_ + most - 1 - back) % most]; }
  void begin() noexcept;
  bool is_near(const Values& at, double dt) const noexcept;
  void fit(Nanoseconds stamp) noexcept;

  std::array<Pose, most> poses_{};  // ring buffer
  std::size_t next_ = 0, count_ = 0;
  Pose newest_{};                 // last accepted pose, also if too close to enter the ring
  Values slope_{}, curvature_{};  // of the parabola at the newest pose; second derivatives
  bool fitted_ = false;
  int outside_ = 0;
};

}  // namespace sightline::dds
