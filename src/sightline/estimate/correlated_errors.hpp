/// Correlated errors of a filter's measurements, as states of the filter.
#pragma once

#include <array>
#include <cstddef>

#include "sightline/estimate/kalman.hpp"
#include "sightline/estimator.hpp"

namespace sightline {

/// Errors of up to `sources` sensor pairs (observed bodies, and the compass), four states x each. The
/// error of a measurement (position in S, yaw) with the covariance R is
///
///   e = L x,   L L^T = R,   x(t + dt) = e^{-dt/T} x(t) + sqrt(1 - e^{-2 dt/T}) w,   E x x^T = 1,
///
/// so it has the covariance R at each time and the correlation time T. A compass uses the last state.
/// A filter carries the error states at the rows from `at` on of its covariance P.
///
/// A source has states from its first measurement on. Beyond `sources` of them, or where R is not
/// positive definite, a measurement counts as white.
template <int sources>
struct CorrelatedErrors {
  static constexpr int states = 4 * sources;
  static constexpr int free = -2;  ///< in `source`

  std::array<Column<4>, static_cast<std::size_t>(sources)> x{};
  std::array<int, static_cast<std::size_t>(sources)> source = filled();

  /// A measurement without the estimate of its error, and what is left of it: e = L x of the states
  /// from `row` on, which is -1 if the error is white.
  struct Corrected {
    Measurement z;
    int row = -1;
    Mat<4, 4> L{};

    /// Adds the columns of the error states to the innovation of a sighting or a heading.
    /// @param R  from S to the frame of its position
    template <int n>
    void add_columns(const Mat<3, 3>& R, Innovation<4, n>& of) const noexcept {
      if (row < 0) return;
      const double sign = z.of == Measures::heading ? 1.0 : -1.0;  // psi = psi_other - yaw
      set_block(of.H, 3, row, sign * block<1, 4>(L, 3, 0));
      if (z.of == Measures::sighting) set_block(of.H, 0, row, R * block<3, 4>(L, 0, 0));
    }
  };

  /// Covariance at the start.
  template <int n>
  void begin(Mat<n, n>& P, int at) const noexcept {
    if constexpr (sources > 0) set_block(P, at, at, identity<states>());
  }
  /// Propagates over dt [s].
  template <int n>
  void advance(Mat<n, n>& P, int at, const FilterOptions& options, double dt) noexcept {
    for (int k = 0; k < sources; ++k) {
      const double keep = MarkovStep(dt, time_of(source[index(k)], options)).keep;
      x[index(k)] = keep * x[index(k)];
      for (int i = at + 4 * k; i < at + 4 * (k + 1); ++i) {
        for (int j = 0; j < n; ++j) P(i, j) *= keep;
        for (int j = 0; j < n; ++j) P(j, i) *= keep;
        P(i, i) += 1 - square(keep);
      }
    }
  }
  /// Gives the source of a measurement states if its errors are correlated.
  void receive(const Measurement& z, const FilterOptions& options) noexcept {
    if (z.of == Measures::position || !(time_of(z.source, options) > 0)) return;
    for (int& one : source) {
      if (one == z.source) return;
      if (one != free) continue;
      one = z.source;
      return;
    }
  }
  Corrected corrected(const Measurement& z, int at) const noexcept {
    Corrected result{z};
    if (z.of == Measures::position) return result;
    for (int k = 0; k < sources; ++k) {
      if (source[index(k)] != z.source) continue;
      Mat<4, 4> R;
      set_block(R, 0, 0, z.of == Measures::heading ? identity<3>() : z.R);
      set_both(R, 0, 3, column(z.R_yaw));
      R(3, 3) = z.yaw_variance;
      const Cholesky<4> factor(R);
      if (!factor.positive) return result;
      const Column<4> e = factor.L * x[index(k)];
      result.row = at + 4 * k;
      result.L = factor.L;
      result.z.z = z.z - vec3(e);
      result.z.yaw = z.yaw - e(3, 0);
      result.z.R = {};
      result.z.R_yaw = {};
      result.z.yaw_variance = 0.0;
    }
    return result;
  }
  template <int n>
  void correct(const Column<n>& e, int at) noexcept {
    for (int k = 0; k < sources; ++k) x[index(k)] += block<4, 1>(e, at + 4 * k, 0);
  }

 private:
  static constexpr std::size_t index(int k) noexcept { return static_cast<std::size_t>(k); }
  static constexpr auto filled() noexcept {
    std::array<int, static_cast<std::size_t>(sources)> none{};
    none.fill(free);
    return none;
  }
  static double time_of(int source, const FilterOptions& options) noexcept {
    return source == compass_source ? options.compass_time : options.correlation_time;
  }
};

/// What a pose (p, psi) that a sighting implies shares with the error x of that sighting: the
/// covariances with x, and what the joint error of position and yaw adds to those of (p, psi).
struct SharedError {
  Mat<3, 4> p;    ///< of p and x
  Mat<1, 4> psi;  ///< of psi and x; 0 if the sighting does not give the heading
  Mat<3, 3> p_p;  ///< added to that of p
  Mat<3, 1> p_psi;

  /// @param L    of the error, CorrelatedErrors
  /// @param psi  heading of the robot [rad]
  SharedError(const Measurement& z, const Mat<4, 4>& L, const SensorMount& mount,
              const Vec2<double>& roll_pitch, double psi_given) noexcept {
    const Place place = place_of(z, mount, roll_pitch, psi_given, 0.0, 0.0);
    const Mat<3, 3> R_VB = mount.frame == MountFrame::body ? tilt(roll_pitch.x, roll_pitch.y) : identity<3>();
    const Mat<3, 3> R_GS = turn_z(psi_given) * R_VB * mount.attitude();
    p = R_GS * block<3, 4>(L, 0, 0);
    if (!z.measures_heading()) return;
    psi = block<1, 4>(L, 3, 0);
    p_psi = column(R_GS * z.R_yaw);
    const Column<3> per_turn = column(place.per_turn);
    const Mat<3, 3> cross = p_psi * transposed(per_turn);
    p += per_turn * psi;
    p_p = cross + transposed(cross);
  }
};

}  // namespace sightline
