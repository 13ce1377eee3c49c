/// How a body moves of which others know only where it is.
#pragma once

#include <array>
#include <optional>

#include "bridges/dds/conversion.hpp"

namespace sightline::dds {

/// Velocity and rate of the heading from poses with stamps: the slope, at the newest, of the parabola that is nearest to
/// the last poses by least squares, for each of x, y, z and the heading.
///
///   poses     of the last 0.1 s, of more where these are less than 4; none older than 0.4 s, at most 64
///   lag       none at constant acceleration. At 100 Hz a sine of 1 Hz comes 1.4 ms late with a gain of 1.04, one of
///             3 Hz 9 ms late with 1.25
///   noise     poses with a standard deviation of s give velocities with 35 s / (1 s) at 100 Hz: 0.3 mm make 0.011 m/s
///   stamps    may have any spacing: what was lost leaves a longer one, jitter of the transport does not matter
///   refused   a stamp that is not newer than the last; a pose beyond 0.05 m + 25 m/s^2 dt^2 or 0.5 rad + 50 rad/s^2 dt^2 of where
///             the parabola leads, up to twice in a row. The third begins anew, as does one after 0.5 s of nothing. Before there is a
///             parabola the body may move by 10 m/s besides
///
/// One thread; allocates and throws nothing.
class VelocityFit {
 public:
  static constexpr std::size_t least = 4, most = 64;
  static constexpr Nanoseconds window = 100'000'000, longest = 400'000'000, silence = 500'000'000;
  static constexpr Nanoseconds densest = 2'000'000;  ///< nearer poses count once
  static constexpr double gate_p = 0.05, gate_v = 10.0, gate_a = 25.0, gate_turn = 0.5, gate_turn_a = 50.0;
  static constexpr int most_outside = 2;

  enum class Outcome { good, too_few, repeated, jump };

  /// Takes in a pose that is finite, with its stamp by the sender's clock. A body without a heading has q = no_attitude.
  /// @param motion  all of it, where the outcome is good
  Outcome take(const Vec3<double>& p, const Quaternion& q, Nanoseconds stamp, Motion& motion) noexcept;

 private:
  using Values = std::array<double, 4>;  // x, y, z [m], heading [rad], which goes on beyond pi
  struct Pose {
    Nanoseconds stamp = 0;
    Values at{};
  };
  const Pose& pose(std::size_t back) const noexcept { return poses_[(next_ + most - 1 - back) % most]; }
  void begin() noexcept;
  bool is_near(const Values& at, double dt) const noexcept;
  void fit(Nanoseconds stamp) noexcept;

  std::array<Pose, most> poses_{};  // a ring
  std::size_t next_ = 0, count_ = 0;
  Pose newest_{};                 // taken, whether it is in the ring or too near to the one before
  Values slope_{}, curvature_{};  // of the parabola at the newest; second derivatives
  bool fitted_ = false;
  int outside_ = 0;
};

}  // namespace sightline::dds
