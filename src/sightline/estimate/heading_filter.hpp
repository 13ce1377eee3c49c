/// Position and heading of a robot that is told its velocity, yaw rate, roll and pitch.
#pragma once

#include "sightline/estimate/kalman.hpp"
#include "sightline/estimate/place.hpp"
#include "sightline/estimate/pose_filter.hpp"

namespace sightline {

/// State x and error state e, x <- x + e:
///
///   p      in G [m]                         p'   = R_GV(psi) (v_told - b_v)
///   psi    heading [rad]                    psi' = rate_told - b_r
///   b_v    bias of the velocity, in V       Gauss-Markov
///   b_r    bias of the yaw rate             random walk
///   tau    true less told roll and pitch    Gauss-Markov
///
/// A sighting z in S of a body at p_t is compared in V: with m = R_VB(told + tau) (d_s e_x + R_BS z) measured
/// and
/// e = R_GV^T (p_t - p) expected, y = m - e and
///
///   dy: e_p: R_GV^T,  e_psi: e_z x e,  e_tau: (R_y e_x) x m and e_y x m.
///
/// The heading's error enters e beyond its first order; P_psi^2 e_l e_l^T / 2, e_l the level part of e, is
/// added to the
/// measurement's covariance for it. docs/localization.md derives both.
class HeadingFilter {
 public:
  static constexpr int n = 10;
  struct State {
    Vec3<double> p{};
    double psi = 0.0;
    Vec3<double> velocity_bias{};
    double rate_bias = 0.0;
    Vec2<double> tilt_error{};  ///< of roll, of pitch
    Mat<n, n> P{};
  };

  HeadingFilter(const FilterOptions& options, const SensorMount& mount) : options_(options), mount_(mount) {}

  State begin(const Place& place, double psi, double psi_variance, const MotionSample& motion) const noexcept;
  State begin(const Vec3<double>& p, double psi, const Mat<4, 4>& P,
              const MotionSample& motion) const noexcept;
  Place place_meant(const Measurement& z, double psi, double psi_variance,
                    const MotionSample& motion) const noexcept;

  /// Over dt [s] within or after a sample.
  void advance(State& s, const MotionSample& motion, double dt) const noexcept;
  /// At the end of a sample.
  void end(State&, const MotionSample&) const noexcept {}
  /// Nobody measured the motion of the last `gap` seconds.
  void blur(State& s, double gap) const noexcept;
  /// Position, in the first three rows, and heading. Rows of what is not measured mean nothing.
  Innovation<4, n> innovation(const State& s, const Measurement& z,
                              const MotionSample& motion) const noexcept;
  /// s <- s + e. The covariance is carried along so that a direction in which nothing was learned stays
  /// unknown: a turn about the
  /// body that is seen, as long as no heading is measured.
  void correct(State& s, const Column<n>& e) const noexcept;
  double heading(const State& s) const noexcept { return s.psi; }
  PoseEstimate read(const State& s, const MotionSample& motion) const noexcept;

 private:
  FilterOptions options_;
  SensorMount mount_;
};

}  // namespace sightline
