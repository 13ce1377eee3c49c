/// Position, velocity and attitude of a robot with an inertial measurement unit.
#pragma once

#include "sightline/estimate/kalman.hpp"
#include "sightline/estimate/place.hpp"
#include "sightline/estimate/pose_filter.hpp"

namespace sightline {

/// State and error state, 21 numbers; R exp([theta]) is the true attitude:
///
///   p, v        in G [m], [m/s]              p' = v,   v' = R (force - b_a) - g e_z
///   R, theta    attitude, error in B [rad]   R' = R [gyro - b_g]
///   b_a, b_g    accelerometer and gyroscope  random walks
///   b_v         bias of the told velocity    Gauss-Markov
///   c           turn of the camera           constant; S_true = S exp([c])
///
/// The told velocity is a measurement at the end of each sample, R_GV(yaw)^T v + b_v. A sighting z of a body at
/// p_t is compared in B, d_s e_x + R_BS exp([c]) z with R^T (p_t - p); where a gimbal holds the camera level, in
/// V.
class AttitudeFilter {
 public:
  static constexpr int n = 21;
  struct State {
    Vec3<double> p{}, v{};
    Mat<3, 3> R = identity<3>();
    Vec3<double> force_bias{}, gyro_bias{}, velocity_bias{}, camera_turn{};
    Mat<n, n> P{};
  };

  AttitudeFilter(const FilterOptions& options, const SensorMount& mount) : options_(options), mount_(mount) {}

  State begin(const Place& place, double psi, double psi_variance, const MotionSample& motion) const noexcept;
  State begin(const Vec3<double>& p, double psi, const Mat<4, 4>& P,
              const MotionSample& motion) const noexcept;
  Place place_meant(const Measurement& z, double psi, double psi_variance,
                    const MotionSample& motion) const noexcept;

  /// Over dt [s] within or after a sample.
  void advance(State& s, const MotionSample& motion, double dt) const noexcept;
  /// An error of what the other body tells is fresh to this filter.
  void receive(State&, const Measurement&) const noexcept {}
  /// At the end of a sample: its velocity.
  void end(State& s, const MotionSample& motion) const noexcept;
  /// Nobody measured the motion of the last `gap` seconds.
  void blur(State& s, double gap) const noexcept;
  /// Position, in the first three rows, and heading. Rows of what is not measured mean nothing.
  Innovation<4, n> innovation(const State& s, const Measurement& z,
                              const MotionSample& motion) const noexcept;
  /// s <- s + e. The covariance is carried along so that a direction in which nothing was learned stays unknown:
  /// a turn about the body that is seen, as long as no heading is measured.
  void correct(State& s, const Column<n>& e) const noexcept;
  double heading(const State& s) const noexcept { return yaw_of(s.R); }
  PoseEstimate read(const State& s, const MotionSample& motion) const noexcept;

 private:
  FilterOptions options_;
  SensorMount mount_;
};

}  // namespace sightline
