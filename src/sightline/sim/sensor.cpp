#include "sightline/sim/sensor.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace sightline {

Sensor::Sensor(const Team& team, const SensorOptions& options)
    : noise_(options.noise), delay_(options.delay) {
  Disturbances{.noise = options.noise, .measurement_delay = options.delay}.check();
  require(options.period >= 1e-4, "sensor", "period", options.period, ">= 1e-4 s");
  for (int i = 0; i < team.bodies(); ++i) {
    const auto stream = [&](Chance purpose) { return RandomStream(options.seed, purpose, i); };
    Part part{.model = team.model(BodyId{i}),
              .x = static_cast<std::size_t>(team.state_offset(BodyId{i})),
              .position = stream(Chance::position_noise),
              .heading = stream(Chance::heading_noise),
              .velocity = stream(Chance::velocity_noise),
              .positions = {},
              .headings = {},
              .angles = {},
              .velocities = {}};
    const auto names = part.model.states();
    for (std::size_t k = 0; k < names.size(); ++k) {
      const std::size_t at = part.x + k;
      if (names[k].starts_with("p_")) part.positions.push_back(at);
      if (names[k] == "d_x") part.headings.push_back(at);
      if (names[k] == "psi") part.angles.push_back(at);
      if (names[k].starts_with("v_")) part.velocities.push_back(at);
    }
    const auto& blind = options.velocity_unknown;
    if (std::find(blind.begin(), blind.end(), BodyId{i}) != blind.end()) {
      unknown_.insert(unknown_.end(), part.velocities.begin(), part.velocities.end());
    }
    parts_.push_back(std::move(part));
  }
  times_.resize(static_cast<std::size_t>(std::ceil(options.delay / options.period)) + 2);
  seen_.resize(static_cast<std::size_t>(team.nx()));
  past_.resize(times_.size() * seen_.size());
}

std::span<const double> Sensor::measure(double t, std::span<const double> x) noexcept {
  assert(x.size() == seen_.size() && "the sensor sees the states of its team");
  remember(t, x);
  // The youngest state that is old enough; times are sums of steps, hence the tolerance.
  std::size_t at = oldest_;
  for (std::size_t k = 1; k < count_; ++k) {
    const std::size_t younger = (oldest_ + k) % times_.size();
    if (times_[younger] <= t - delay_ + 1e-9) at = younger;
  }
  std::copy_n(past_.begin() + static_cast<std::ptrdiff_t>(at * seen_.size()), seen_.size(), seen_.begin());
  for (Part& part : parts_) add_noise(part);
  for (const std::size_t i : unknown_) seen_[i] = 0.0;
  return seen_;
}

void Sensor::remember(double t, std::span<const double> x) noexcept {
  if (count_ < times_.size()) {
    ++count_;
  } else {
    oldest_ = (oldest_ + 1) % times_.size();
  }
  const std::size_t newest = (oldest_ + count_ - 1) % times_.size();
  times_[newest] = t;
  std::copy(x.begin(), x.end(), past_.begin() + static_cast<std::ptrdiff_t>(newest * seen_.size()));
}

void Sensor::add_noise(Part& part) noexcept {
  if (noise_.position > 0) {
    for (const std::size_t i : part.positions) seen_[i] += noise_.position * part.position.normal();
  }
  if (noise_.velocity > 0) {
    for (const std::size_t i : part.velocities) seen_[i] += noise_.velocity * part.velocity.normal();
  }
  if (noise_.heading > 0) {
    for (const std::size_t i : part.headings) {
      const SinCos<double> turn = sincos(noise_.heading * part.heading.normal());
      const Vec2<double> d = rotate<double>({turn.cos, turn.sin}, {seen_[i], seen_[i + 1]});
      seen_[i] = d.x;
      seen_[i + 1] = d.y;
    }
    for (const std::size_t i : part.angles) seen_[i] += noise_.heading * part.heading.normal();
    // A state that is no state stays as it is: refusing it is the solver's part.
    static_cast<void>(part.model.normalise(&seen_[part.x]));
  }
}

}  // namespace sightline
