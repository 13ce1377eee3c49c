#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "sightline/model/state_roles.hpp"
#include "sightline/sensors.hpp"

namespace sightline {
namespace {

constexpr double never = -std::numeric_limits<double>::infinity();

}  // namespace

Sensor::Sensor(const Team& team, const SensorOptions& options)
    : noise_(options.noise), delay_(options.delay) {
  Disturbances{.noise = options.noise, .odometry = options.odometry, .measurement_delay = options.delay}
      .check();
  require(options.period >= 1e-4, "sensor", "period", options.period, ">= 1e-4 s");
  for (int i = 0; i < team.bodies(); ++i) {
    const auto stream = [&](StreamId purpose) { return RandomStream(options.seed, purpose, i); };
    Part part{.model = team.model(BodyId{i}),
              .x = static_cast<std::size_t>(team.state_offset(BodyId{i})),
              .position = stream(StreamId::position_noise),
              .heading = stream(StreamId::heading_noise),
              .velocity = stream(StreamId::velocity_noise),
              .positions = {},
              .direction = {},
              .angle = {},
              .velocities = {},
              .odometry = {}};
    const StateRoles roles = roles_of(part.model);
    const auto place = [&](int state) { return part.x + static_cast<std::size_t>(state); };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (roles.position[axis] >= 0) part.positions.push_back({axis, place(roles.position[axis])});
    }
    if (roles.direction[0] >= 0) part.direction = {place(roles.direction[0]), place(roles.direction[1])};
    if (roles.angle >= 0) part.angle = place(roles.angle);
    for (const int state : roles.velocities) part.velocities.push_back(place(state));
    if (team.is_agent(BodyId{i}) && options.odometry != Odometry{})
      part.odometry.emplace(options.odometry, part.velocities.size(), options.seed, i);
    const auto& blind = options.velocity_unknown;
    if (std::find(blind.begin(), blind.end(), BodyId{i}) != blind.end()) {
      unknown_.insert(unknown_.end(), part.velocities.begin(), part.velocities.end());
    }
    parts_.push_back(std::move(part));
  }
  double longest = 0.0;
  for (std::size_t k = 0; k < options.faults.size(); ++k) {
    const Fault& fault = options.faults[k];
    fault.check();
    if (fault.kind == FaultKind::delay) longest += fault.delay;
    for (int i = 0; i < team.bodies(); ++i) {
      const auto part = static_cast<std::size_t>(i);
      if (fault.body.index >= 0 && fault.body != BodyId{i}) continue;
      require(fault.number < parts_[part].model.nx(), "fault", "number", fault.number,
              "a place in the body's state");
      const int stream = static_cast<int>(k) * team.bodies() + i;
      injections_.push_back({fault, part, RandomStream(options.seed, StreamId::fault, stream)});
    }
  }
  times_.resize(static_cast<std::size_t>(std::ceil((options.delay + longest) / options.period)) + 2);
  fresh_.resize(static_cast<std::size_t>(team.nx()));
  seen_.resize(fresh_.size());
  stamps_.resize(parts_.size(), never);
  past_.resize(times_.size() * seen_.size());
  brought_.reserve(Surroundings::faults_max);
}

std::span<const double> Sensor::measure(double t, std::span<const double> x) noexcept {
  if (x.size() != seen_.size()) return seen_;
  const double since = count_ > 0 ? t - times_[(oldest_ + count_ - 1) % times_.size()] : 0.0;
  remember(t, x);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    FaultEffect effect;
    for (const Injection& one : injections_) {
      const bool strikes = one.part == i && one.fault.strikes(BodyId{static_cast<int>(i)}, t);
      if (strikes && one.fault.kind == FaultKind::delay) effect.delay += one.fault.delay;
    }
    const std::size_t at = youngest(t - delay_ - effect.delay);
    const auto nx = static_cast<std::ptrdiff_t>(part.model.nx());
    const auto begin = static_cast<std::ptrdiff_t>(part.x);
    std::copy_n(past_.begin() + static_cast<std::ptrdiff_t>(at * seen_.size()) + begin, nx,
                fresh_.begin() + begin);
    add_noise(part);
    if (part.odometry) add_drift(part, since);
    for (const std::size_t k : unknown_) fresh_[k] = 0.0;
    apply_faults(i, t, effect);
    const bool first = stamps_[i] == never;
    if (first || !(effect.lost || effect.frozen))
      std::copy_n(fresh_.begin() + begin, nx, seen_.begin() + begin);
    if (!effect.lost) stamps_[i] = times_[at];
  }
  return seen_;
}

void Sensor::begin(BodyId body, std::span<const double> x) noexcept {
  const Part& part = parts_[at(body)];
  const auto nx = static_cast<std::size_t>(part.model.nx());
  std::copy_n(&x[part.x], nx, &seen_[part.x]);
  for (std::size_t at = part.x; at < past_.size(); at += seen_.size())
    std::copy_n(&x[part.x], nx, &past_[at]);
}

/// Index of the youngest state not after `until`, or the oldest. Times are sums of steps, hence the
/// tolerance.
std::size_t Sensor::youngest(double until) const noexcept {
  std::size_t at = oldest_;
  for (std::size_t k = 1; k < count_; ++k) {
    const std::size_t younger = (oldest_ + k) % times_.size();
    if (times_[younger] <= until + 1e-9) at = younger;
  }
  return at;
}

void Sensor::apply_faults(std::size_t part, double t, FaultEffect& effect) noexcept {
  const Part& of = parts_[part];
  const BodyId body{static_cast<int>(part)};
  for (Injection& one : injections_) {
    if (one.part != part || !one.fault.strikes(body, t)) continue;
    // Draws both numbers in any case, so that one fault leaves the others unchanged.
    const bool hit = one.chance.uniform() <= one.fault.probability;
    const double which = one.chance.uniform();
    apply_fault(one.fault, of, hit, which, effect);
  }
  for (const Fault& one : brought_)
    if (one.strikes(body, t)) apply_fault(one, of, true, 0.0, effect);
}

void Sensor::apply_fault(const Fault& fault, const Part& part, bool hit, double which,
                         FaultEffect& effect) noexcept {
  const std::size_t n = static_cast<std::size_t>(part.model.nx());
  switch (fault.kind) {
    case FaultKind::dropout:
      effect.lost |= hit;
      break;
    case FaultKind::delay:
      break;
    case FaultKind::freeze:
      effect.frozen = true;
      break;
    case FaultKind::nan: {
      const auto drawn = std::min(static_cast<std::size_t>(which * static_cast<double>(n)), n - 1);
      const std::size_t number = fault.number >= 0 ? static_cast<std::size_t>(fault.number) : drawn;
      if (hit) fresh_[part.x + number] = std::numeric_limits<double>::quiet_NaN();
      break;
    }
    case FaultKind::jump:
      for (const auto& [axis, at] : part.positions) {
        const Vec3<double>& d = fault.offset;
        if (hit) fresh_[at] += axis == 0 ? d.x : axis == 1 ? d.y : d.z;
      }
      break;
  }
}

void Sensor::surround(const Surroundings& around) noexcept {
  constexpr std::array kinds = {FaultKind::dropout, FaultKind::freeze, FaultKind::jump};  // index: one.kind
  brought_.clear();
  for (const Surroundings::Fault& one : around.faults) {
    if (brought_.size() == brought_.capacity()) return;
    brought_.push_back({.kind = kinds[static_cast<std::size_t>(one.kind)],
                        .body = one.body,
                        .from = one.from,
                        .until = one.until,
                        .offset = one.offset});
  }
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
    for (const auto& [axis, at] : part.positions) fresh_[at] += noise_.position * part.position.normal();
  }
  if (noise_.velocity > 0) {
    for (const std::size_t i : part.velocities) fresh_[i] += noise_.velocity * part.velocity.normal();
  }
  if (noise_.heading > 0) turn(part, noise_.heading * part.heading.normal());
}

void Sensor::turn(const Part& part, double angle) noexcept {
  if (part.direction) {
    const auto [x, y] = *part.direction;
    const SinCos<double> turned = sincos(angle);
    const Vec2<double> d = rotate<double>({turned.cos, turned.sin}, {fresh_[x], fresh_[y]});
    fresh_[x] = d.x;
    fresh_[y] = d.y;
  }
  if (part.angle) fresh_[*part.angle] += angle;
  // An invalid state stays as it is: the solver rejects it.
  static_cast<void>(part.model.normalise(&fresh_[part.x]));
}

void Sensor::add_drift(Part& part, double since) noexcept {
  OdometryErrors& off = *part.odometry;
  if (since > 0) off.advance(since);
  const Vec3<double>& p = off.position();
  for (const auto& [axis, at] : part.positions) fresh_[at] += axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  for (std::size_t i = 0; i < part.velocities.size(); ++i) {
    double& v = fresh_[part.velocities[i]];
    v += off.velocity(i, v);
  }
  if (off.heading() != 0) turn(part, off.heading());
}

}  // namespace sightline
