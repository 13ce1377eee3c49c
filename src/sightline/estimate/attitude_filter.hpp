/// Filter for position, velocity and attitude of a robot with an inertial measurement unit.
#pragma once

#include "sightline/estimate/correlated_errors.hpp"
#include "sightline/estimate/kalman.hpp"
#include "sightline/estimator.hpp"

namespace sightline {

/// State and error state, 21 numbers; R exp([theta]) is the true attitude:
///
///   p, v        in G [m], [m/s]              p' = v,   v' = R (force - b_a) - g e_z
///   R, theta    attitude, error in B [rad]   R' = R [gyro - b_g]
///   b_a, b_g    accelerometer and gyroscope  random walks
///   b_v         bias of the reported v       Gauss-Markov
///   c           rotation of the camera       constant; S_true = S exp([c])
///
/// The reported velocity is a measurement at the end of each sample, R_GV(yaw)^T v + b_v. A
/// sighting z of a body at p_t gives d_s e_x + R_BS exp([c]) z in B. It is compared with R^T (p_t -
/// p); with a gimbal that levels the camera, the comparison is in V.
///
/// The last part of the state is the correlated errors of `sources` sensor pairs.
template <int sources>
class AttitudeFilterOf {
 public:
  static constexpr int n = 21 + 4 * sources;
  struct State {
    Vec3<double> p{}, v{};
    Mat<3, 3> R = identity<3>();
    Vec3<double> force_bias{}, gyro_bias{}, velocity_bias{}, camera_turn{};
    CorrelatedErrors<sources> errors{};
    Mat<n, n> P{};
  };

  AttitudeFilterOf(const FilterOptions& options, const SensorMount& mount)
      : options_(options), mount_(mount) {}

  State begin(const Place& place, double psi, double psi_variance, const MotionSample& motion) const noexcept;
  State begin(const Vec3<double>& p, double psi, const Mat<4, 4>& P,
              const MotionSample& motion) const noexcept;
  Place place_meant(const Measurement& z, double psi, double psi_variance,
                    const MotionSample& motion) const noexcept;

  /// After the begin from a sighting: the pose shares the error of that sighting.
  void share(State& s, const Measurement& z, const MotionSample& motion) const noexcept;
  /// Propagates over dt [s], within a sample or after it.
  void advance(State& s, const MotionSample& motion, double dt) const noexcept;
  /// Before a measurement: states for the errors of its source. Each message of the other body counts
  /// as having a new, independent error.
  void receive(State& s, const Measurement& z) const noexcept { s.errors.receive(z, options_); }
  /// Update at the end of a sample with its velocity.
  void end(State& s, const MotionSample& motion) const noexcept;
  /// Adds the uncertainty of `gap` [s] without measured motion.
  void blur(State& s, double gap) const noexcept;
  /// Innovation of position (rows 0 to 2) and heading (row 3). Rows that are not measured are
  /// undefined.
  Innovation<4, n> innovation(const State& s, const Measurement& z,
                              const MotionSample& motion) const noexcept;
  /// s <- s + e. The covariance is transformed so that an unobserved direction stays unobserved:
  /// the rotation about the observed body while no heading is measured.
  void correct(State& s, const Column<n>& e) const noexcept;
  double heading(const State& s) const noexcept { return yaw_of(s.R); }
  PoseEstimate read(const State& s, const MotionSample& motion) const noexcept;

 private:
  static constexpr int errors_at = n - CorrelatedErrors<sources>::states;
  FilterOptions options_;
  SensorMount mount_;
};

using AttitudeFilter = AttitudeFilterOf<0>;

extern template class AttitudeFilterOf<0>;
extern template class AttitudeFilterOf<1>;
extern template class AttitudeFilterOf<correlated_sources_max>;

}  // namespace sightline
