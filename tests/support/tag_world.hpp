/// The model's world with cameras on some robots: detections of upright bodies, by the noise of
/// tags of 0.2 m at 320x240.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <utility>
#include <vector>

#include "sightline/world/sighting.hpp"
#include "sightline/worlds.hpp"

namespace sightline::test {

class TagWorld final : public World {
 public:
  struct Camera {
    BodyId observer{}, target{};
    SensorMount mount{};
  };
  /// Nothing is seen in this time [s].
  struct Hidden {
    double from = 1e9, until = 1e9;
  };

  TagWorld(Team team, std::vector<double> x0, std::vector<Camera> cameras, const PlantOptions& plant = {},
           Hidden hidden = {1e9, 1e9})
      : model_(std::move(team), std::move(x0), plant),
        cameras_(std::move(cameras)),
        hidden_(hidden),
        chance_(plant.seed, StreamId::run, 7) {}

  const Team& team() const noexcept override { return model_.team(); }
  std::span<const double> start() const noexcept override { return model_.start(); }
  MeasuredMost measured_max() const noexcept override { return {.detections = 16}; }
  void set_presence(std::span<const Presence> presence) noexcept override { model_.set_presence(presence); }
  Measured measure(double t) noexcept override {
    Measured now = model_.measure(t);
    if (t >= next_ - 1e-9) {
      next_ += 1 / 30.0;
      for (const Camera& camera : cameras_) expose(camera, t, now.truth);
    }
    arrived_.clear();
    std::erase_if(flying_, [&](const Detection& d) {
      if (d.arrival > t) return false;
      arrived_.push_back(d);
      return true;
    });
    now.detections = arrived_;
    return now;
  }
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override {
    return model_.apply(t, estimated, u, period, periods);
  }
  int detections() const { return seen_; }

 private:
  Sight<double> sight(BodyId body, std::span<const double> x) const {
    const std::vector<double> u(static_cast<std::size_t>(team().model(body).nu()));
    return team().model(body).sight(&x[static_cast<std::size_t>(team().state_offset(body))], u.data());
  }
  static Mat<3, 3> upright_attitude(const Sight<double>& s) { return turn_z(std::atan2(s.d.y, s.d.x)); }

  void expose(const Camera& camera, double t, std::span<const double> x) {
    const Sight<double> own = sight(camera.observer, x), other = sight(camera.target, x);
    const Mat<3, 3> R_GB = upright_attitude(own), R_GS = R_GB * camera.mount.attitude();
    const Vec3<double> p = camera.mount(static_cast<const Pose<double>&>(own), other.p);
    const double latency = 0.03 + 0.05 * chance_.uniform(), lost = chance_.uniform();
    const Vec3<double> noise = chance_.normals(), turned = chance_.normals();
    if (p.x < 0.3 || off_axis(p) > 0.5 || norm(p) > 3 || lost < 0.05) return;
    if (t >= hidden_.from && t < hidden_.until) return;
    const double n = 207.8 * 0.2 / p.x, range = norm(p);
    const double s_range = range * (1.7 / (n * n) + 7e-4), s_side = range * 27 * std::pow(n, -1.5) / 207.8,
                 s_turn = std::min(0.3, 5 / (n * n) + 0.001);
    const Vec3<double> l = (1 / range) * p;
    const Mat<3, 3> P = (s_side * s_side) * (identity<3>() - outer(l, l)) + (s_range * s_range) * outer(l, l);
    Detection d{
        .observer = camera.observer, .target = camera.target, .stamp = t, .arrival = t + latency, .tags = 1};
    d.p = p - Cholesky<3>(P).L * noise;
    const Mat<3, 3> q = turn(-s_turn * turned) * transposed(R_GS) * upright_attitude(other);
    Eigen::Matrix3d m;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m(i, j) = q(i, j);
    const Eigen::Quaterniond e(m);
    d.q = {e.w(), e.x(), e.y(), e.z()};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = i; j < 3; ++j) d.covariance[Detection::place(i, j)] = P.row[i][j];
      d.covariance[Detection::place(3 + i, 3 + i)] = s_turn * s_turn;
    }
    flying_.push_back(d);
    ++seen_;
  }

  ModelWorld model_;
  std::vector<Camera> cameras_;
  Hidden hidden_;
  RandomStream chance_;
  double next_ = 0.0;
  int seen_ = 0;
  std::vector<Detection> flying_, arrived_;
};

}  // namespace sightline::test
