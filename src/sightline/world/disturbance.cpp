#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/base/split_mix.hpp"
#include "sightline/potential.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {}  // namespace

bool Disturbances::spoil_measurements() const {
  return noise.position > 0 || noise.heading > 0 || noise.velocity > 0 || odometry != Odometry{} ||
         measurement_delay > 0;
}

void Disturbances::check() const {
  const auto expect = [](bool holds, std::string_view field, double value, std::string_view expected) {
    require(holds, "disturbance", field, value, expected);
  };
  for (const double w : {wind.x, wind.y, wind.z}) expect(true, "wind", w, "finite m/s^2");
  expect(gust_sigma >= 0, "gust.sigma", gust_sigma, ">= 0 m/s^2");
  expect(gust_time > 0, "gust.time", gust_time, "> 0 s");
  check_parameters(airflow, "disturbance.airflow");
  check_parameters(noise, "disturbance.noise");
  check_parameters(odometry, "disturbance.odometry");
  check_parameters(*this, "disturbance");
}

RandomStream::RandomStream(std::uint64_t seed, StreamId purpose, int body) : state_(seed) {
  state_ = next_split_mix(state_) + static_cast<std::uint64_t>(purpose);
  state_ = next_split_mix(state_) + static_cast<std::uint64_t>(body);
  state_ = next_split_mix(state_);
}

std::uint64_t RandomStream::bits() noexcept { return next_split_mix(state_); }

double RandomStream::uniform() noexcept { return (static_cast<double>(bits() >> 11) + 1.0) * 0x1p-53; }

double RandomStream::normal() noexcept {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = sqrt(-2.0 * std::log(uniform()));
  const SinCos<double> turn = sincos(2 * std::numbers::pi * uniform());
  spare_ = radius * turn.sin;
  has_spare_ = true;
  return radius * turn.cos;
}

Vec3<double> RandomStream::normals() noexcept {
  const double x = normal(), y = normal(), z = normal();
  return {x, y, z};
}

Gusts::Gusts(double sigma, double time, int robots, std::uint64_t seed) : sigma_(sigma), time_(time) {
  for (int i = 0; i < robots; ++i) {
    streams_.emplace_back(seed, StreamId::gust, i);
    a_.push_back(sigma_ * streams_.back().normals());
  }
}

void Gusts::advance(double s) noexcept {
  const MarkovStep step(s, time_);
  const double fresh = sigma_ * step.fresh;
  for (std::size_t i = 0; i < a_.size(); ++i) a_[i] = step.keep * a_[i] + fresh * streams_[i].normals();
}

Wakes::Wakes(const Airflow& airflow, int robots, std::uint64_t seed) : airflow_(airflow) {
  for (int i = 0; i < robots; ++i) {
    RandomStream& stream = streams_.emplace_back(seed, StreamId::wake, i);
    phase_.push_back(2 * std::numbers::pi * stream.uniform());
    swing_.push_back(sin(phase_.back()));
  }
}

void Wakes::push(std::span<const Vec3<double>> p, std::span<Vec3<double>> acceleration) const noexcept {
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t j = 0; j < p.size(); ++j) {
      const Vec3<double> line = p[i] - p[j];
      const double level = sqrt(square(line.x) + square(line.y));
      if (!(level > 0)) continue;  // itself, or a robot vertically above: no lateral direction
      const double near = std::min(square(airflow_.distance) / dot(line, line), Airflow::strongest);
      const double push = airflow_.amplitude * near * swing_[j] / level;
      acceleration[i].x -= push * line.y;
      acceleration[i].y += push * line.x;
    }
  }
}

void Wakes::advance(double s) noexcept {
  const double turn = 2 * std::numbers::pi * airflow_.frequency * s, spread = Airflow::wander * sqrt(s);
  for (std::size_t i = 0; i < phase_.size(); ++i) {
    phase_[i] = std::fmod(phase_[i] + turn + spread * streams_[i].normal(), 2 * std::numbers::pi);
    swing_[i] = sin(phase_[i]);
  }
}

OdometryErrors::OdometryErrors(const Odometry& odometry, std::size_t velocities, std::uint64_t seed, int body)
    : odometry_(odometry),
      of_position_(seed, StreamId::position_drift, body),
      of_heading_(seed, StreamId::heading_drift, body),
      of_velocity_(seed, StreamId::velocity_drift, body),
      position_(odometry.position_bias * of_position_.normals()),
      heading_(odometry.heading_bias * of_heading_.normal()),
      scale_(odometry.velocity_scale * of_velocity_.normal()) {
  for (std::size_t i = 0; i < velocities; ++i)
    velocity_.push_back(odometry.velocity_bias * of_velocity_.normal());
}

void OdometryErrors::advance(double s) noexcept {
  const double root = sqrt(s);
  const Odometry& o = odometry_;
  if (o.position_walk > 0) position_ = position_ + (o.position_walk * root) * of_position_.normals();
  if (o.heading_walk > 0) heading_ += o.heading_walk * root * of_heading_.normal();
  if (o.velocity_walk > 0) {
    for (double& v : velocity_) v += o.velocity_walk * root * of_velocity_.normal();
  }
}

InputDelay::InputDelay(double delay, double period, std::span<const double> initial)
    : delay_(delay),
      nu_(initial.size()),
      arrival_(static_cast<std::size_t>(std::ceil(delay / period)) + 3),
      rows_(arrival_.size() * nu_) {
  std::copy(initial.begin(), initial.end(), rows_.begin());
}

void InputDelay::give(double t, std::span<const double> u) noexcept {
  if (waiting_ + 1 < arrival_.size()) ++waiting_;
  arrival_[row(waiting_)] = t + delay_;
  std::copy(u.begin(), u.end(), rows_.begin() + static_cast<std::ptrdiff_t>(row(waiting_) * nu_));
}

std::span<const double> InputDelay::at(double t) noexcept {
  while (waiting_ > 0 && arrival_[row(1)] <= t + same_time) {
    held_ = row(1);
    --waiting_;
  }
  return std::span(rows_).subspan(held_ * nu_, nu_);
}

double InputDelay::next_arrival() const noexcept {
  return waiting_ > 0 ? arrival_[row(1)] : std::numeric_limits<double>::infinity();
}

}  // namespace sightline
