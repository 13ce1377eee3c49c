#include "sightline/estimate/attitude_filter.hpp"

namespace sightline {
namespace {

constexpr int v_at = 3, theta_at = 6, force_bias_at = 9, gyro_bias_at = 12, velocity_bias_at_row = 15,
              camera_turn_at = 18;
constexpr double start_speed = 0.5;  // sigma of v at the start, in addition to the reported velocity's [m/s]

/// Row d yaw / d theta.
Mat<1, 3> yaw_row(const Mat<3, 3>& R) {
  const Vec3<double> g = yaw_gradient(R);
  return {{{{g.x, g.y, g.z}}}};
}

/// d (R_GV^T a) / d yaw for a_V = R_GV^T a.
Column<3> turned_back(const Vec3<double>& a_V) { return column({a_V.y, -a_V.x, 0.0}); }

/// T P T^T of a symmetric P, given the effect of T on the rows. The result is symmetric except for
/// rounding, which the next update removes.
template <int n, class Rows>
void both_sides(Mat<n, n>& P, const Rows& rows) {
  rows(P);
  P = transposed(P);
  rows(P);
}

template <class State>
double yaw_variance(const State& s) {
  const Mat<1, 3> g = yaw_row(s.R);
  return (g * block<3, 3>(s.P, theta_at, theta_at) * transposed(g))(0, 0);
}

}  // namespace

template <int sources>
typename AttitudeFilterOf<sources>::State AttitudeFilterOf<sources>::begin(
    const Vec3<double>& p, double psi, const Mat<4, 4>& P, const MotionSample& motion) const noexcept {
  State s;
  s.p = p;
  s.R = turn_z(psi) * tilt(motion.roll, motion.pitch);
  s.v = turn_z(psi) * motion.v_V;
  const Vec3<double> up_B = transposed(s.R) * Vec3<double>{0, 0, 1};
  set_block(s.P, 0, 0, block<3, 3>(P, 0, 0));
  set_block(s.P, v_at, v_at, identity<3>(square(start_speed)));
  set_block(s.P, theta_at, theta_at, identity<3>(square(options_.tilt_bias)) + P(3, 3) * outer(up_B, up_B));
  set_both(s.P, 0, theta_at, block<3, 1>(P, 0, 3) * transposed(column(up_B)));
  set_block(s.P, force_bias_at, force_bias_at, identity<3>(square(options_.accelerometer_bias)));
  set_block(s.P, gyro_bias_at, gyro_bias_at, identity<3>(square(options_.gyro_bias)));
  set_block(s.P, velocity_bias_at_row, velocity_bias_at_row, identity<3>(square(options_.velocity_bias)));
  set_block(s.P, camera_turn_at, camera_turn_at, identity<3>(square(options_.camera_turn)));
  s.errors.begin(s.P, errors_at);
  return s;
}

template <int sources>
typename AttitudeFilterOf<sources>::State AttitudeFilterOf<sources>::begin(
    const Place& place, double psi, double psi_variance, const MotionSample& motion) const noexcept {
  Mat<4, 4> P;
  set_block(P, 0, 0, place.P);
  P(3, 3) = psi_variance;
  set_both(P, 0, 3, psi_variance * column(place.per_turn));
  return begin(place.p, psi, P, motion);
}

template <int sources>
Place AttitudeFilterOf<sources>::place_meant(const Measurement& z, double psi, double psi_variance,
                                             const MotionSample& motion) const noexcept {
  return place_of(z, mount_, tilt_at(motion, z.stamp), psi, psi_variance,
                  square(options_.tilt_bias) + square(options_.camera_turn));
}

template <int sources>
void AttitudeFilterOf<sources>::share(State& s, const Measurement& z,
                                      const MotionSample& motion) const noexcept {
  if constexpr (sources > 0) {
    s.errors.receive(z, options_);
    const auto seen = s.errors.corrected(z, errors_at);
    if (seen.row < 0) return;
    const SharedError shared(z, seen.L, mount_, tilt_at(motion, z.stamp), yaw_of(s.R));
    const Column<3> up_B = column(transposed(s.R) * Vec3<double>{0, 0, 1});
    set_block(s.P, 0, 0, block<3, 3>(s.P, 0, 0) + shared.p_p);
    set_both(s.P, 0, theta_at, block<3, 3>(s.P, 0, theta_at) + shared.p_psi * transposed(up_B));
    set_both(s.P, 0, seen.row, shared.p);
    set_both(s.P, theta_at, seen.row, up_B * shared.psi);
  } else {
    (void)s, (void)z, (void)motion;
  }
}

template <int sources>
void AttitudeFilterOf<sources>::advance(State& s, const MotionSample& motion, double dt) const noexcept {
  if (!(dt > 0)) return;
  const Vec3<double> f = motion.force - s.force_bias;
  const Vec3<double> a = s.R * f - Vec3<double>{0, 0, gravity};
  const Mat<3, 3> E = turn(dt * (motion.gyro - s.gyro_bias)), back = transposed(E);
  const Mat<3, 3> R = s.R, RF = s.R * cross_matrix(f);
  const double keep = exp(-dt / options_.velocity_bias_time);
  s.p = s.p + dt * s.v + (0.5 * dt * dt) * a;
  s.v = s.v + dt * a;
  s.R = orthonormal(s.R * E);
  s.velocity_bias = keep * s.velocity_bias;

  // F P, for the rows of P that F changes.
  both_sides(s.P, [&](Mat<n, n>& P) {
    const Mat<3, n> theta = block<3, n>(P, theta_at, 0), v = block<3, n>(P, v_at, 0);
    const Mat<3, n> d_v = (-dt) * (RF * theta + R * block<3, n>(P, force_bias_at, 0));
    set_block(P, 0, 0, block<3, n>(P, 0, 0) + dt * v + (0.5 * dt) * d_v);
    set_block(P, v_at, 0, v + d_v);
    set_block(P, theta_at, 0, back * theta - dt * block<3, n>(P, gyro_bias_at, 0));
    set_block(P, velocity_bias_at_row, 0, keep * block<3, n>(P, velocity_bias_at_row, 0));
  });

  const double share = FilterOptions::white_period * dt;
  for (int i = 0; i < 3; ++i) {
    s.P(v_at + i, v_at + i) += square(options_.accelerometer_noise) * share;
    s.P(theta_at + i, theta_at + i) += square(options_.gyro_noise) * share;
    s.P(force_bias_at + i, force_bias_at + i) += square(options_.accelerometer_walk) * dt;
    s.P(gyro_bias_at + i, gyro_bias_at + i) += square(options_.gyro_walk) * dt;
    s.P(velocity_bias_at_row + i, velocity_bias_at_row + i) +=
        square(options_.velocity_bias) * (1 - square(keep));
  }
  s.errors.advance(s.P, errors_at, options_, dt);
}

template <int sources>
void AttitudeFilterOf<sources>::end(State& s, const MotionSample& motion) const noexcept {
  const Mat<3, 3> R_VG = turn_z(-yaw_of(s.R));
  const Vec3<double> v_V = R_VG * s.v;
  Innovation<3, n> of{};
  of.y = column(motion.v_V - v_V - s.velocity_bias);
  set_block(of.H, 0, v_at, R_VG);
  set_block(of.H, 0, theta_at, turned_back(v_V) * yaw_row(s.R));
  set_block(of.H, 0, velocity_bias_at_row, identity<3>());
  of.R = identity<3>(square(options_.velocity_noise) * FilterOptions::white_period / motion.dt);
  Column<n> e;
  if (update(s.P, of, e).accepted) correct(s, e);
}

template <int sources>
void AttitudeFilterOf<sources>::blur(State& s, double gap) const noexcept {
  for (int i = 0; i < 3; ++i) {
    s.P(i, i) += square(0.5 * unmeasured_acceleration * gap * gap);
    s.P(v_at + i, v_at + i) += square(unmeasured_acceleration * gap);
    s.P(theta_at + i, theta_at + i) += square(0.5 * unmeasured_turning * gap * gap);
  }
}

template <int sources>
Innovation<4, AttitudeFilterOf<sources>::n> AttitudeFilterOf<sources>::innovation(
    const State& s, const Measurement& received, const MotionSample&) const noexcept {
  Innovation<4, n> of{};
  const auto seen = s.errors.corrected(received, errors_at);
  const Measurement& z = seen.z;
  of.y(3, 0) = wrap(z.heading() - yaw_of(s.R));
  set_block(of.H, 3, theta_at, yaw_row(s.R));
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
  const Mat<3, 3> C = mount_.attitude() * turn(s.camera_turn);
  const Vec3<double> r = z.p_other - s.p, m = mount_.offset + C * z.z;
  const bool leans = mount_.frame == MountFrame::body;
  const Mat<3, 3> back = leans ? transposed(s.R) : turn_z(-yaw_of(s.R));
  const Vec3<double> e = back * r, level = back * Vec3<double>{r.x, r.y, 0.0};
  // A camera rotation also changes the measured heading of the other body, about the vertical in S.
  const Vec3<double> up_S = transposed(C) * (leans ? transposed(s.R) : identity<3>()) * Vec3<double>{0, 0, 1};
  of.y(3, 0) = wrap(of.y(3, 0) - dot(up_S, s.camera_turn));
  set_block(of.H, 3, camera_turn_at, transposed(column(up_S)));
  set_block(of.y, 0, 0, column(m - e));
  set_block(of.H, 0, 0, -1.0 * back);
  set_block(of.H, 0, theta_at, leans ? cross_matrix(e) : turned_back(e) * yaw_row(s.R));
  set_block(of.H, 0, camera_turn_at, C * cross_matrix(z.z));
  set_block(of.R, 0, 0,
            C * z.R * transposed(C) + back * block<3, 3>(z.P_other, 0, 0) * transposed(back) +
                0.5 * square(yaw_variance(s)) * outer(level, level));
  set_both(of.R, 0, 3, -1.0 * column(C * z.R_yaw) - back * block<3, 1>(z.P_other, 0, 3));
  seen.add_columns(C, of);
  return of;
}

template <int sources>
void AttitudeFilterOf<sources>::correct(State& s, const Column<n>& e) const noexcept {
  const Vec3<double> d_p = vec3(e), d_v = vec3(e, v_at), up_before = transposed(s.R) * Vec3<double>{0, 0, 1};
  const Mat<3, 3> before = s.R;
  s.p = s.p + d_p;
  s.v = s.v + d_v;
  s.R = orthonormal(s.R * turn(vec3(e, theta_at)));
  s.force_bias = s.force_bias + vec3(e, force_bias_at);
  s.gyro_bias = s.gyro_bias + vec3(e, gyro_bias_at);
  s.velocity_bias = s.velocity_bias + vec3(e, velocity_bias_at_row);
  s.camera_turn = s.camera_turn + vec3(e, camera_turn_at);
  s.errors.correct(e, errors_at);

  // The correction moved p and v. A rotation of the whole estimate about the vertical moves p by
  // e_z x p and v by e_z x v, so these directions changed. The axes of theta changed with B.
  const Mat<3, 3> turned = transposed(s.R) * before;
  both_sides(s.P, [&](Mat<n, n>& P) {
    const Mat<3, n> theta = block<3, n>(P, theta_at, 0);
    const Mat<1, n> yaw = transposed(column(up_before)) * theta;
    for (int j = 0; j < n; ++j) {
      P(0, j) -= d_p.y * yaw(0, j), P(1, j) += d_p.x * yaw(0, j);
      P(v_at, j) -= d_v.y * yaw(0, j), P(v_at + 1, j) += d_v.x * yaw(0, j);
    }
    set_block(P, theta_at, 0, turned * theta);
  });
}

template <int sources>
PoseEstimate AttitudeFilterOf<sources>::read(const State& s, const MotionSample& motion) const noexcept {
  PoseEstimate estimate{.known = true, .p = s.p, .v = s.v, .psi = yaw_of(s.R)};
  const Mat<1, 3> g = yaw_row(s.R);
  estimate.yaw_rate = vec3(transposed(g)).y * (motion.gyro.y - s.gyro_bias.y) +
                      vec3(transposed(g)).z * (motion.gyro.z - s.gyro_bias.z);
  set_block(estimate.P, 0, 0, block<3, 3>(s.P, 0, 0));
  set_both(estimate.P, 0, 3, block<3, 3>(s.P, 0, theta_at) * transposed(g));
  estimate.P(3, 3) = yaw_variance(s);
  estimate.velocity_sigma = sqrt(s.P(v_at, v_at) + s.P(v_at + 1, v_at + 1) + s.P(v_at + 2, v_at + 2));
  estimate.yaw_rate_sigma = sqrt(s.P(gyro_bias_at + 2, gyro_bias_at + 2));
  return estimate;
}

template class AttitudeFilterOf<0>;
template class AttitudeFilterOf<1>;
template class AttitudeFilterOf<correlated_sources_max>;

}  // namespace sightline
