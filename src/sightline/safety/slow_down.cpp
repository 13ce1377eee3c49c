#include "sightline/safety/slow_down.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace sightline {
namespace {

constexpr double usable = 0.98;  // part of the deceleration: the heading turns in a period
constexpr double nearly_kept = 1e-9;

std::vector<double> periods_of(const SlowDownOptions& options) {
  return std::vector<double>(size(static_cast<int>(std::ceil(options.delay / options.period - 1e-6))));
}

}  // namespace

double least_deceleration(const ViewMotion& motion, double wind) noexcept {
  const double most =
      motion.across.input < 0 ? motion.along.most : std::min(motion.along.most, motion.across.most);
  return usable * (most - wind);
}

double gain_until_slow(const SlowDownOptions& o, double age) noexcept {
  const double faster = o.unrequested - o.speed;
  return faster * (o.delay + 3 * o.period + 2 * age) + faster * faster / (2 * o.slowing);
}

SlowDown::SlowDown(const Model& model, std::span<const double> u_min, std::span<const double> u_max,
                   const SlowDownOptions& options)
    : model_(model),
      motion_(view_motion(model, u_min, u_max)),
      options_(options),
      under_way_(periods_of(options)),
      x_(size(model.nx())) {
  if (model.nx() > ViewFilter::most_states || model.nu() > ViewFilter::most_inputs)
    throw_invalid(
        "\"{}\" has {} states and {} inputs, expected at most {} and {} for a robot that slows down",
        model.name(), model.nx(), model.nu(), ViewFilter::most_states, ViewFilter::most_inputs);
}

double SlowDown::speed_after(std::span<const double> u) const noexcept {
  std::array<double, ViewFilter::most_states> x;
  std::copy(x_.begin(), x_.end(), x.begin());
  model_.step(x.data(), u.data(), options_.period);
  const Vec3<double> v = model_.sight(x.data(), u.data()).v;
  return norm(v.x, v.y);
}

void SlowDown::filter(bool requested, std::span<const double> x, std::span<double> u) noexcept {
  assert(x.size() == x_.size() && u.size() == size(model_.nu()));
  std::copy(x.begin(), x.end(), x_.begin());
  if (!under_way_.empty()) {
    requested = std::exchange(under_way_[next_], requested ? 1.0 : 0.0) > 0;
    next_ = (next_ + 1) % under_way_.size();
  }
  const Sight<double> now = model_.sight(x.data(), u.data());
  const double speed = norm(now.v.x, now.v.y), slower = speed - options_.slowing * options_.period;
  bound_ = std::max(requested ? options_.speed : options_.unrequested, slower);

  if (const ViewMotion::Axis& axis = motion_.climb; axis.input >= 0) {
    const double most = options_.climb / std::abs(axis.gain);
    double& climb = u[size(axis.input)];
    climb = std::clamp(climb, -most, most);
  }
  if (keeps(u)) return;
  // Full braking, without a reversal in the period.
  const Vec2<double> v = rotate<double>({now.d.x, -now.d.y}, {now.v.x, now.v.y});
  std::array<double, ViewFilter::most_inputs> wanted{}, braking{}, mixed{};
  std::copy(u.begin(), u.end(), wanted.begin());
  braking = wanted;
  const auto brake = [&](const ViewMotion::Axis& axis, double along) {
    if (axis.input < 0) return;
    const double most = std::min(axis.most, speed / options_.period);
    braking[size(axis.input)] = speed > 0 ? -most * along / speed / axis.gain : 0.0;
  };
  brake(motion_.along, v.x), brake(motion_.across, v.y);
  double enough = 1.0, little = 0.0;
  constexpr int halvings = 20;
  for (int k = 0; k < halvings; ++k) {
    const double middle = 0.5 * (enough + little);
    for (std::size_t i = 0; i < u.size(); ++i) mixed[i] = wanted[i] + middle * (braking[i] - wanted[i]);
    (keeps(std::span(mixed).first(u.size())) ? enough : little) = middle;
  }
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = wanted[i] + enough * (braking[i] - wanted[i]);
}

bool SlowDown::keeps(std::span<const double> u) const noexcept {
  const ViewMotion::Axis& axis = motion_.climb;
  return speed_after(u) <= bound_ + nearly_kept &&
         (axis.input < 0 || std::abs(axis.gain * u[size(axis.input)]) <= options_.climb + nearly_kept);
}

}  // namespace sightline
