/// A robot that flies beside a body and sees it: the truth, and what its sensors make of it. No
/// solver, no plant: smooth curves.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/estimator.hpp"
#include "sightline/world.hpp"

namespace sightline::test {

struct SyntheticOptions {
  std::uint64_t seed = 1;
  double camera_rate = 30.0, broadcast_rate = 100.0;  // [Hz]
  double latency_min = 0.03, latency_max = 0.08;      // of a picture [s]
  double dropout = 0.05, outliers = 0.0, flips = 0.0;
  double misalignment = 0.0;                   // of the camera [rad]
  double correlation_time = 0.0;               // of the errors of pictures [s]
  double blind_from = 1e9, blind_until = 1e9;  // [s]
  bool yaw = true, hovers = false;
  SensorMount mount{.pitch = 0.5, .offset = 0.17, .frame = MountFrame::body};
  FilterOptions errors{};  // what the sensors are like
};

struct TruePose {
  Vec3<double> p{}, v{};
  double psi = 0.0, roll = 0.0, pitch = 0.0;
  Mat<3, 3> R() const { return turn_z(psi) * tilt(roll, pitch); }
};

/// What one robot's sensors make of the truth.
class SyntheticSensors {
 public:
  static constexpr double dt = 0.01;

  SyntheticSensors(const SyntheticOptions& options, int robot)
      : o(options),
        motion_(options.seed, StreamId::motion, robot),
        camera_(options.seed, StreamId::run, robot),
        error_(options.correlation_time),
        velocity_bias_(options.errors.velocity_bias * motion_.normals()),
        rate_bias_(options.errors.yaw_rate_bias * motion_.normal()) {
    tilt_error_ = {o.errors.tilt_bias * motion_.normal(), o.errors.tilt_bias * motion_.normal()};
    gyro_bias_ = o.errors.gyro_bias * motion_.normals();
    force_bias_ = o.errors.accelerometer_bias * motion_.normals();
    turn_ = turn(o.misalignment * camera_.normals());
  }

  /// Of the period from t, with the truth at its two ends.
  MotionSample motion(double t, const TruePose& a, const TruePose& b) {
    const FilterOptions& e = o.errors;
    const double turned = wrap(b.psi - a.psi), keep_v = std::exp(-dt / e.velocity_bias_time),
                 keep_tilt = std::exp(-dt / e.tilt_time);
    velocity_bias_ =
        keep_v * velocity_bias_ + (e.velocity_bias * std::sqrt(1 - keep_v * keep_v)) * motion_.normals();
    for (double* error : {&tilt_error_.x, &tilt_error_.y})
      *error = keep_tilt * *error + e.tilt_bias * std::sqrt(1 - keep_tilt * keep_tilt) * motion_.normal();
    rate_bias_ += e.yaw_rate_walk * std::sqrt(dt) * motion_.normal();
    gyro_bias_ = gyro_bias_ + (e.gyro_walk * std::sqrt(dt)) * motion_.normals();
    force_bias_ = force_bias_ + (e.accelerometer_walk * std::sqrt(dt)) * motion_.normals();
    MotionSample u{.t = t, .dt = dt};
    u.v_V = turn_z(-a.psi - 0.5 * turned) * ((1 / dt) * (b.p - a.p)) + velocity_bias_ +
            e.velocity_noise * motion_.normals();
    u.yaw_rate = turned / dt + rate_bias_ + e.yaw_rate_noise * motion_.normal();
    u.roll = a.roll - tilt_error_.x + e.tilt_noise * motion_.normal();
    u.pitch = a.pitch - tilt_error_.y + e.tilt_noise * motion_.normal();
    u.gyro = (1 / dt) * logarithm(transposed(a.R()) * b.R()) + gyro_bias_ + e.gyro_noise * motion_.normals();
    u.force = transposed(a.R()) * ((1 / dt) * (b.v - a.v) + Vec3<double>{0, 0, gravity}) + force_bias_ +
              e.accelerometer_noise * motion_.normals();
    return u;
  }
  /// A picture of another body, with its arrival; none that is lost.
  std::optional<std::pair<double, Measurement>> expose(double t, const TruePose& own_pose,
                                                       const TruePose& other) {
    const Mat<3, 3> held = o.mount.frame == MountFrame::body ? own_pose.R() : turn_z(own_pose.psi);
    const Mat<3, 3> R_GS = held * o.mount.attitude() * turn_;
    const Vec3<double> z = transposed(R_GS) * (other.p - own_pose.p - held * o.mount.offset);
    const double range = norm(z), n = 207.8 * 0.2 / z.x;
    const double s_range = range * (1.7 / (n * n) + 7e-4), s_side = range * 27 * std::pow(n, -1.5) / 207.8,
                 s_yaw = std::min(0.3, 5 / (n * n) + 0.001);
    const double latency = o.latency_min + (o.latency_max - o.latency_min) * camera_.uniform();
    const bool lost = camera_.uniform() <= o.dropout || (t >= o.blind_from && t < o.blind_until);
    const bool outlier = camera_.uniform() <= o.outliers, flip = camera_.uniform() <= o.flips;
    const double kind = camera_.uniform(), w = camera_.uniform(), side = camera_.uniform() - 0.5;
    Column<4> drawn;
    for (int i = 0; i < 4; ++i) drawn(i, 0) = camera_.normal();
    const Column<4>& error = error_.at(t, drawn);
    const Vec3<double> noise = vec3(error), l = (1 / range) * z;
    Measurement m{.stamp = t};
    m.R = (s_side * s_side) * (identity<3>() - outer(l, l)) + (s_range * s_range) * outer(l, l);
    const Mat<3, 3> L = Cholesky<3>(m.R).L;
    m.z = z + L * noise;
    m.has_yaw = o.yaw;
    // The other's heading in V, by where the camera is supposed to sit.
    const Mat<3, 3> R_VB = turn_z(-own_pose.psi) * held, R_BS = o.mount.attitude();
    const Mat<3, 3> R_VT = R_VB * R_BS * transposed(turn_) * transposed(R_BS) * transposed(R_VB) *
                           turn_z(other.psi - own_pose.psi);
    m.yaw = wrap(yaw_of(R_VT) + s_yaw * error(3, 0)), m.yaw_variance = s_yaw * s_yaw;
    if (outlier && kind < 0.5) m.z = {0.5 + 3 * w, 2 * side, side}, m.yaw = 6 * (kind - 0.25);
    if (outlier && kind >= 0.5) m.z = (1.1 + 0.4 * w) * m.z;
    if (flip) m.yaw = wrap(m.yaw + (side < 0 ? 1 : -1) * (0.35 + w));
    if (lost) return std::nullopt;
    return std::pair{t + latency, m};
  }

 private:
  static Vec3<double> logarithm(const Mat<3, 3>& R) {
    const Vec3<double> s = {0.5 * (R(2, 1) - R(1, 2)), 0.5 * (R(0, 2) - R(2, 0)), 0.5 * (R(1, 0) - R(0, 1))};
    const double sine = norm(s);
    return sine > 1e-9 ? (std::asin(sine) / sine) * s : s;
  }

  const SyntheticOptions o;
  RandomStream motion_, camera_;
  GaussMarkov<4> error_;
  Vec3<double> velocity_bias_;
  double rate_bias_;
  Vec3<double> gyro_bias_{}, force_bias_{};
  Vec2<double> tilt_error_{};
  Mat<3, 3> turn_{};
};

/// A pose with a place's velocity by differences.
template <class Place>
TruePose moving(const Place& place, double t) {
  constexpr double h = 1e-3;
  return {.p = place(t), .v = (0.5 / h) * (place(t + h) - place(t - h))};
}

/// What motion capture broadcasts of a body; its errors are white.
inline BroadcastPose broadcast_of(double t, const TruePose& q, double yaw_rate, RandomStream& radio) {
  constexpr double sigma = 0.01, v_sigma = 0.03;
  BroadcastPose m{.stamp = t, .p = q.p + sigma * radio.normals(), .v = q.v + v_sigma * radio.normals()};
  m.psi = wrap(q.psi + sigma * radio.normal()), m.yaw_rate = yaw_rate;
  m.P = identity<4>(sigma * sigma);
  return m;
}

class SyntheticFlight {
 public:
  static constexpr double dt = SyntheticSensors::dt;

  explicit SyntheticFlight(const SyntheticOptions& options)
      : o(options),
        draw_(options.seed, StreamId::draw, 0),
        radio_(options.seed, StreamId::position_noise, 0),
        sensors_(options, 0),
        track_({.sighting_rate = options.camera_rate}) {
    for (double& phase : phases_) phase = 2 * std::numbers::pi * draw_.uniform();
    for (double& rate : rates_) rate = 0.2 + 0.3 * draw_.uniform();
  }

  double now() const { return static_cast<double>(k_) * dt; }
  TruePose own() const { return own(now()); }

  /// One period: the motion in it, and what has arrived at its end.
  MotionSample advance(std::vector<Measurement>& arrived) {
    const double t = now(), next = t + dt;
    const MotionSample u = sensors_.motion(t, own(t), own(next));
    ++k_;
    for (; next_message_ <= t; next_message_ += 1 / o.broadcast_rate) tell(next_message_);
    for (; next_picture_ < next - 1e-9; next_picture_ += 1 / o.camera_rate) {
      const double at = next_picture_;
      if (auto picture = sensors_.expose(at, own(at), target(at))) pictures_.push_back(*picture);
    }
    std::erase_if(messages_, [&](const auto& m) {
      if (m.first > next) return false;
      track_.take(m.second);
      return true;
    });
    arrived.clear();
    std::erase_if(pictures_, [&](const auto& picture) {
      if (picture.first > next) return false;
      Measurement z = picture.second;
      if (const std::optional<KnownPose> pose = track_.at(z.stamp)) {
        z.p_other = pose->p, z.psi_other = pose->psi, z.P_other = pose->P;
        arrived.push_back(z);
      }
      return true;
    });
    return u;
  }

  TruePose target(double t) const {
    TruePose q = moving([&](double s) { return target_place(s); }, t);
    q.psi = wrap(0.2 * t + phases_[6]);
    return q;
  }
  TruePose own(double t) const {
    TruePose q = moving([&](double s) { return own_place(s); }, t);
    const Vec3<double> r = target_place(t) - q.p;
    q.psi = wrap(std::atan2(r.y, r.x) + 0.1 * swing(3, t));
    q.roll = 0.05 * std::sin(1.3 * t + phases_[7]), q.pitch = 0.05 * std::cos(1.1 * t + phases_[8]);
    return q;
  }

  const SyntheticOptions o;

 private:
  double swing(std::size_t i, double t) const { return std::sin(rates_[i] * t + phases_[i]); }
  Vec3<double> target_place(double t) const {
    if (o.hovers) return {0, 0, 1.2};
    return {0.8 * swing(0, t), 0.8 * swing(1, t), 1.2 + 0.2 * swing(2, t)};
  }
  Vec3<double> own_place(double t) const {
    const double angle = phases_[4] + (o.hovers ? 0.0 : 0.5 * swing(4, t)), away = 1.4;
    return target_place(t) + Vec3<double>{away * std::cos(angle), away * std::sin(angle),
                                          0.7 + (o.hovers ? 0.0 : 0.15 * swing(5, t))};
  }
  void tell(double t) {
    const BroadcastPose m = broadcast_of(t, target(t), 0.2, radio_);
    const double arrival = t + 0.02 + 0.01 * radio_.uniform();
    if (radio_.uniform() > 0.02) messages_.emplace_back(arrival, m);
  }

  RandomStream draw_, radio_;
  std::array<double, 9> phases_{}, rates_{};
  SyntheticSensors sensors_;
  BroadcastTrack track_;
  std::int64_t k_ = 0;
  double next_message_ = 0.0, next_picture_ = 0.0;
  std::vector<std::pair<double, BroadcastPose>> messages_;  // with their arrival
  std::vector<std::pair<double, Measurement>> pictures_;
};

/// Error of an estimate, (p, psi), against the truth of its time.
inline Column<4> pose_error(const PoseEstimate& estimate, const TruePose& truth) {
  const Vec3<double> e = estimate.p - truth.p;
  return {{{{e.x}, {e.y}, {e.z}, {wrap(estimate.psi - truth.psi)}}}};
}

/// What many flights say of a filter, from `from` on.
struct Consistency {
  double squares = 0.0, turns = 0.0, nees = 0.0;
  long samples = 0;
  int restarts = 0, unknown = 0;

  void add(const PoseEstimate& estimate, const TruePose& truth) {
    const Column<4> e = pose_error(estimate, truth);
    squares += e(0, 0) * e(0, 0) + e(1, 0) * e(1, 0) + e(2, 0) * e(2, 0), turns += e(3, 0) * e(3, 0);
    nees += mahalanobis(e, estimate.P);
    ++samples;
  }
  double rmse() const { return std::sqrt(squares / static_cast<double>(samples)); }
  double heading() const { return std::sqrt(turns / static_cast<double>(samples)); }
  double anees() const { return nees / static_cast<double>(samples); }
};

/// Flies `flights` synthetic flights of `duration` [s] through filters of these options.
inline Consistency fly_filters(const FilterOptions& filter_options, SyntheticOptions options, int flights,
                               double duration, double from = 3.0) {
  Consistency result;
  std::vector<Measurement> arrived;
  for (int i = 0; i < flights; ++i) {
    options.seed = 100 + static_cast<std::uint64_t>(i);
    SyntheticFlight flight(options);
    const auto filter = make_pose_filter(filter_options, options.mount);
    while (flight.now() < duration) {
      filter->advance(flight.advance(arrived));
      for (const Measurement& z : arrived)
        result.restarts += filter->take(z).verdict == FitVerdict::restarted;
      if (flight.now() < from) continue;
      const PoseEstimate estimate = filter->estimate();
      if (!estimate.known) ++result.unknown;
      if (estimate.known) result.add(estimate, flight.own());
    }
  }
  return result;
}

}  // namespace sightline::test
