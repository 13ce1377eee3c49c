/// Filter for position and heading of a robot whose autopilot reports velocity, yaw rate, roll and
/// pitch.
#pragma once

#include <array>
#include <cstddef>

#include "sightline/estimate/correlated_errors.hpp"
#include "sightline/estimate/kalman.hpp"
#include "sightline/estimator.hpp"

namespace sightline {

/// Transition matrix F of one HeadingFilter step, and its process noise.
struct HeadingTransition {
  double dt;
  Vec3<double> v_G;
  SinCos<double> heading;
  double keep_bias, keep_tilt;

  /// Applies F to rows 0 to 9 of P, with the given number of columns; P(i, j) is an entry. With
  /// rows and columns exchanged it gives P F^T.
  template <class Entry>
  void rows(int columns, const Entry& P) const noexcept {
    for (int j = 0; j < columns; ++j) {
      P(0, j) += dt * (-v_G.y * P(3, j) - heading.cos * P(4, j) + heading.sin * P(5, j));
      P(1, j) += dt * (v_G.x * P(3, j) - heading.sin * P(4, j) - heading.cos * P(5, j));
      P(2, j) -= dt * P(6, j);
      P(3, j) -= dt * P(7, j);
      for (int i = 4; i < 7; ++i) P(i, j) *= keep_bias;
      for (int i = 8; i < 10; ++i) P(i, j) *= keep_tilt;
    }
  }
  /// Adds the process noise Q.
  template <class Entry>
  void add_noise(const FilterOptions& options, const Entry& P) const noexcept {
    const double share = FilterOptions::white_period * dt;
    for (int i = 0; i < 3; ++i) {
      P(i, i) += square(options.velocity_noise) * share;
      P(4 + i, 4 + i) += square(options.velocity_bias) * (1 - square(keep_bias));
    }
    P(3, 3) += square(options.yaw_rate_noise) * share;
    P(7, 7) += square(options.yaw_rate_walk) * dt;
    for (int i = 8; i < 10; ++i) P(i, i) += square(options.tilt_bias) * (1 - square(keep_tilt));
  }
};

/// State x and error state e, x <- x + e; v_m, r_m, roll and pitch are the reported values:
///
///   p      in G [m]                         p'   = R_GV(psi) (v_m - b_v)
///   psi    heading [rad]                    psi' = r_m - b_r
///   b_v    bias of the velocity, in V       Gauss-Markov
///   b_r    bias of the yaw rate             random walk
///   tau    true minus reported tilt         Gauss-Markov
///
/// A sighting z in S of a body at p_t is compared in V. Measured is m = R_VB(tilt + tau) (d_s e_x +
/// R_BS z), with the reported tilt (roll, pitch); expected is e = R_GV^T (p_t - p). The innovation
/// is y = m - e with
///
///   dy: e_p: R_GV^T,  e_psi: e_z x e,  e_tau: (R_y e_x) x m and e_y x m.
///
/// The heading error enters e beyond its first order. For this, P_psi^2 e_l e_l^T / 2, e_l the
/// level part of e, is added to the covariance of the measurement.
///
/// With `others` = 1 the state has one more part, for an observed robot that is itself localized
/// and broadcasts its estimate:
///
///   b      its true pose (p, psi) minus the broadcast one   Gauss-Markov, broadcast covariance
///
/// This is a Schmidt-Kalman filter with a Markov model of the other robot's error. Sightings with
/// OtherError::lasting share b. The last part is the correlated errors of `sources` sensor pairs.
template <int others, int sources>
class HeadingFilterOf {
  static_assert(others == 0 || others == 1);

 public:
  static constexpr int n = 10 + 4 * others + 4 * sources;
  struct State {
    Vec3<double> p{};
    double psi = 0.0;
    Vec3<double> velocity_bias{};
    double rate_bias = 0.0;
    Vec2<double> tilt_error{};  ///< of roll and pitch [rad]
    std::array<Column<4>, static_cast<std::size_t>(others)> other_error{};
    std::array<Mat<4, 4>, static_cast<std::size_t>(others)>
        other_reported{};  ///< covariance in its last message
    CorrelatedErrors<sources> errors{};
    Mat<n, n> P{};
  };

  HeadingFilterOf(const FilterOptions& options, const SensorMount& mount)
      : options_(options), mount_(mount) {}

  State begin(const Place& place, double psi, double psi_variance, const MotionSample& motion) const noexcept;
  State begin(const Vec3<double>& p, double psi, const Mat<4, 4>& P,
              const MotionSample& motion) const noexcept;
  Place place_meant(const Measurement& z, double psi, double psi_variance,
                    const MotionSample& motion) const noexcept;

  /// After the begin from a sighting: the pose shares the error of that sighting.
  void share(State& s, const Measurement& z, const MotionSample& motion) const noexcept;
  /// Propagates the state, without its covariance, over dt [s] > 0, within a sample or after it.
  HeadingTransition move(State& s, const MotionSample& motion, double dt) const noexcept;
  /// Propagates state and covariance; does nothing if dt is not positive.
  void advance(State& s, const MotionSample& motion, double dt) const noexcept;
  /// Before a measurement: states for the errors of its source, and the covariance of the other
  /// robot's error from its message.
  void receive(State& s, const Measurement& z) const noexcept;
  /// At the end of a sample: no effect.
  void end(State&, const MotionSample&) const noexcept {}
  /// Adds the uncertainty of `gap` [s] without measured motion.
  void blur(State& s, double gap) const noexcept;
  /// Innovation of position (rows 0 to 2) and heading (row 3). Rows that are not measured are
  /// undefined.
  Innovation<4, n> innovation(const State& s, const Measurement& z,
                              const MotionSample& motion) const noexcept;
  /// s <- s + e. The covariance is transformed so that an unobserved direction stays unobserved:
  /// the rotation about the observed body while no heading is measured.
  void correct(State& s, const Column<n>& e) const noexcept;
  double heading(const State& s) const noexcept { return s.psi; }
  PoseEstimate read(const State& s, const MotionSample& motion) const noexcept;

 private:
  static constexpr int errors_at = n - CorrelatedErrors<sources>::states;
  FilterOptions options_;
  SensorMount mount_;
};

using HeadingFilter = HeadingFilterOf<0, 0>;
/// For a robot that observes a robot which is itself localized.
using ChainFilter = HeadingFilterOf<1, 0>;

extern template class HeadingFilterOf<0, 0>;
extern template class HeadingFilterOf<0, 1>;
extern template class HeadingFilterOf<0, correlated_sources_max>;
extern template class HeadingFilterOf<1, 0>;
extern template class HeadingFilterOf<1, 1>;
extern template class HeadingFilterOf<1, correlated_sources_max>;

}  // namespace sightline
