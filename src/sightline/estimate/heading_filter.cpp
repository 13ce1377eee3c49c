#include "sightline/estimate/heading_filter.hpp"

namespace sightline {
namespace {

constexpr int psi_at = 3, velocity_bias_at = 4, rate_bias_at = 7, tilt_at_row = 8, other_at = 10;

}  // namespace

template <int others, int sources>
typename HeadingFilterOf<others, sources>::State HeadingFilterOf<others, sources>::begin(
    const Vec3<double>& p, double psi, const Mat<4, 4>& P, const MotionSample&) const noexcept {
  State s;
  s.p = p, s.psi = wrap(psi);
  set_block(s.P, 0, 0, P);
  set_block(s.P, velocity_bias_at, velocity_bias_at, identity<3>(square(options_.velocity_bias)));
  s.P(rate_bias_at, rate_bias_at) = square(options_.yaw_rate_bias);
  set_block(s.P, tilt_at_row, tilt_at_row, identity<2>(square(options_.tilt_bias)));
  s.errors.begin(s.P, errors_at);
  return s;
}

template <int others, int sources>
typename HeadingFilterOf<others, sources>::State HeadingFilterOf<others, sources>::begin(
    const Place& place, double psi, double psi_variance, const MotionSample& motion) const noexcept {
  Mat<4, 4> P;
  set_block(P, 0, 0, place.P);
  P(psi_at, psi_at) = psi_variance;
  set_both(P, 0, psi_at, psi_variance * column(place.per_turn));
  return begin(place.p, psi, P, motion);
}

template <int others, int sources>
Place HeadingFilterOf<others, sources>::place_meant(const Measurement& z, double psi, double psi_variance,
                                                    const MotionSample& motion) const noexcept {
  return place_of(z, mount_, tilt_at(motion, z.stamp), psi, psi_variance,
                  square(options_.tilt_bias) + square(options_.tilt_noise));
}

template <int others, int sources>
void HeadingFilterOf<others, sources>::share(State& s, const Measurement& z,
                                             const MotionSample& motion) const noexcept {
  if constexpr (sources > 0) {
    s.errors.receive(z, options_);
    const auto seen = s.errors.corrected(z, errors_at);
    if (seen.row < 0) return;
    const SharedError shared(z, seen.L, mount_, tilt_at(motion, z.stamp), s.psi);
    set_block(s.P, 0, 0, block<3, 3>(s.P, 0, 0) + shared.p_p);
    set_both(s.P, 0, psi_at, block<3, 1>(s.P, 0, psi_at) + shared.p_psi);
    set_both(s.P, 0, seen.row, shared.p);
    set_both(s.P, psi_at, seen.row, shared.psi);
  } else {
    (void)s, (void)z, (void)motion;
  }
}

template <int others, int sources>
HeadingTransition HeadingFilterOf<others, sources>::move(State& s, const MotionSample& motion,
                                                         double dt) const noexcept {
  const SinCos<double> h = sincos(s.psi);
  const Vec3<double> v = motion.v_V - s.velocity_bias;
  const Vec3<double> v_G = {h.cos * v.x - h.sin * v.y, h.sin * v.x + h.cos * v.y, v.z};
  const double keep_bias = exp(-dt / options_.velocity_bias_time), keep_tilt = exp(-dt / options_.tilt_time);
  s.p = s.p + dt * v_G;
  s.psi = wrap(s.psi + dt * (motion.yaw_rate - s.rate_bias));
  s.velocity_bias = keep_bias * s.velocity_bias;
  s.tilt_error = {keep_tilt * s.tilt_error.x, keep_tilt * s.tilt_error.y};
  return {dt, v_G, h, keep_bias, keep_tilt};
}

template <int others, int sources>
void HeadingFilterOf<others, sources>::advance(State& s, const MotionSample& motion,
                                               double dt) const noexcept {
  if (!(dt > 0)) return;
  const HeadingTransition step = move(s, motion, dt);
  step.rows(n, [&](int i, int j) -> double& { return s.P(i, j); });
  step.rows(n, [&](int i, int j) -> double& { return s.P(j, i); });
  if constexpr (others > 0) {
    const double keep = exp(-dt / options_.other_error_time);
    s.other_error[0] = keep * s.other_error[0];
    for (int i = other_at; i < other_at + 4; ++i) {
      for (int j = 0; j < n; ++j) s.P(i, j) *= keep;
      for (int j = 0; j < n; ++j) s.P(j, i) *= keep;
    }
    const double fresh = 1 - square(keep);
    set_block(s.P, other_at, other_at, block<4, 4>(s.P, other_at, other_at) + fresh * s.other_reported[0]);
  }
  s.errors.advance(s.P, errors_at, options_, dt);
  make_symmetric(s.P);
  step.add_noise(options_, [&](int i, int j) -> double& { return s.P(i, j); });
}

template <int others, int sources>
void HeadingFilterOf<others, sources>::receive(State& s, const Measurement& z) const noexcept {
  s.errors.receive(z, options_);
  if constexpr (others > 0) {
    if (z.of != Measures::sighting || z.other_error != OtherError::lasting) return;
    // For each correlation time within the spread, the spectrum of this process is nowhere below
    // that of the error.
    const Mat<4, 4> received = options_.other_error_spread * z.P_other;
    if (trace(s.other_reported[0]) == 0) set_block(s.P, other_at, other_at, received);
    s.other_reported[0] = received;
  }
}

template <int others, int sources>
void HeadingFilterOf<others, sources>::blur(State& s, double gap) const noexcept {
  for (int i = 0; i < 3; ++i) s.P(i, i) += square(0.5 * unmeasured_acceleration * gap * gap);
  s.P(psi_at, psi_at) += square(0.5 * unmeasured_turning * gap * gap);
}

template <int others, int sources>
Innovation<4, HeadingFilterOf<others, sources>::n> HeadingFilterOf<others, sources>::innovation(
    const State& s, const Measurement& received, const MotionSample& motion) const noexcept {
  Innovation<4, n> of{};
  const auto seen = s.errors.corrected(received, errors_at);
  const Measurement& z = seen.z;
  of.y(3, 0) = wrap(z.heading() - s.psi);
  of.H(3, psi_at) = 1.0;
  of.R(3, 3) = z.heading_variance();
  if (z.of == Measures::heading) {
    seen.add_columns(identity<3>(), of);
    return of;
  }
  if (z.of == Measures::position) {
    set_block(of.y, 0, 0, column(z.z - s.p));
    set_block(of.H, 0, 0, identity<3>());
    set_block(of.R, 0, 0, z.R);
    return of;
  }
  const bool leans = mount_.frame == MountFrame::body;
  const Vec2<double> reported = tilt_at(motion, z.stamp);
  const double pitch = reported.y + s.tilt_error.y;
  const Mat<3, 3> R_VB = leans ? tilt(reported.x + s.tilt_error.x, pitch) : identity<3>();
  const Mat<3, 3> R_VS = R_VB * mount_.attitude(), R_VG = turn_z(-s.psi);
  const Vec3<double> m = R_VB * mount_.offset + R_VS * z.z;
  const bool lasting = others > 0 && z.other_error == OtherError::lasting;
  Vec3<double> p_other = z.p_other;
  if constexpr (others > 0) {
    if (lasting) {
      p_other = p_other + vec3(s.other_error[0]);
      of.y(3, 0) = wrap(of.y(3, 0) + s.other_error[0](3, 0));
      set_block(of.H, 0, other_at, R_VG);
      of.H(3, other_at + 3) = -1.0;
    }
  }
  const Vec3<double> e = R_VG * (p_other - s.p);
  set_block(of.y, 0, 0, column(m - e));
  set_block(of.H, 0, 0, -1.0 * R_VG);
  of.H(0, psi_at) = e.y, of.H(1, psi_at) = -e.x;
  Mat<3, 3> R = R_VS * z.R * transposed(R_VS);
  Column<3> R_yaw = -1.0 * column(R_VS * z.R_yaw);
  if (lasting) {
    of.R(3, 3) = z.yaw_variance;
  } else {
    R += R_VG * block<3, 3>(z.P_other, 0, 0) * transposed(R_VG);
    R_yaw = R_yaw - R_VG * block<3, 1>(z.P_other, 0, 3);
  }
  const Vec3<double> level = {e.x, e.y, 0.0};
  R += 0.5 * square(s.P(psi_at, psi_at)) * outer(level, level);
  if (leans) {
    // -(a x m) = [m] a: errors of roll and pitch rotate m about these axes, and m enters y with the
    //   opposite sign.
    const SinCos<double> b = sincos(pitch);
    const Vec3<double> by_roll = cross_matrix(m) * Vec3<double>{b.cos, 0, -b.sin};
    const Vec3<double> by_pitch = cross_matrix(m) * Vec3<double>{0, 1, 0};
    set_block(of.H, 0, tilt_at_row, column(by_roll));
    set_block(of.H, 0, tilt_at_row + 1, column(by_pitch));
    R += square(options_.tilt_noise) * (outer(by_roll, by_roll) + outer(by_pitch, by_pitch));
  }
  set_block(of.R, 0, 0, R);
  set_both(of.R, 0, 3, R_yaw);
  seen.add_columns(R_VS, of);
  return of;
}

template <int others, int sources>
void HeadingFilterOf<others, sources>::correct(State& s, const Column<n>& e) const noexcept {
  const Vec3<double> d = vec3(e);
  s.p = s.p + d;
  s.psi = wrap(s.psi + e(psi_at, 0));
  s.velocity_bias = s.velocity_bias + vec3(e, velocity_bias_at);
  s.rate_bias += e(rate_bias_at, 0);
  s.tilt_error = {s.tilt_error.x + e(tilt_at_row, 0), s.tilt_error.y + e(tilt_at_row + 1, 0)};
  if constexpr (others > 0) s.other_error[0] += block<4, 1>(e, other_at, 0);
  s.errors.correct(e, errors_at);
  // The correction moved p. A rotation of the whole estimate about the vertical moves p by e_z x p,
  // so this direction changed.
  for (int j = 0; j < n; ++j) s.P(0, j) -= d.y * s.P(psi_at, j), s.P(1, j) += d.x * s.P(psi_at, j);
  for (int j = 0; j < n; ++j) s.P(j, 0) -= d.y * s.P(j, psi_at), s.P(j, 1) += d.x * s.P(j, psi_at);
  make_symmetric(s.P);
}

template <int others, int sources>
PoseEstimate HeadingFilterOf<others, sources>::read(const State& s,
                                                    const MotionSample& motion) const noexcept {
  const Vec3<double> v = turn_z(s.psi) * (motion.v_V - s.velocity_bias);
  return {.known = true,
          .p = s.p,
          .v = v,
          .psi = s.psi,
          .yaw_rate = motion.yaw_rate - s.rate_bias,
          .P = block<4, 4>(s.P, 0, 0),
          .velocity_sigma = sqrt(s.P(4, 4) + s.P(5, 5) + s.P(6, 6) + dot(v, v) * s.P(3, 3)),
          .yaw_rate_sigma = sqrt(s.P(7, 7))};
}

template class HeadingFilterOf<0, 0>;
template class HeadingFilterOf<0, 1>;
template class HeadingFilterOf<0, correlated_sources_max>;
template class HeadingFilterOf<1, 0>;
template class HeadingFilterOf<1, 1>;
template class HeadingFilterOf<1, correlated_sources_max>;

}  // namespace sightline
