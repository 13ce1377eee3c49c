#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "sightline/base.hpp"
#include "sightline/safety/carry.hpp"
#include "sightline/supervisor.hpp"

namespace sightline {
namespace {

constexpr double off_the_circle = 0.05;
constexpr double ahead_max = 0.05;  // tolerance of a stamp after the present time [s]
// A body counts as moved beyond these distances and turns.
constexpr double moved_by = 0.02, turned_by = 0.05;  // [m], [rad]

bool equal_bits(std::span<const double> a, std::span<const double> b) noexcept {
  return std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

double chord(const Vec2<double>& a, const Vec2<double>& b) { return norm(a.x - b.x, a.y - b.y); }

}  // namespace

std::string_view to_string(MeasurementFault fault) {
  constexpr std::array<std::string_view, measurement_fault_count> names = {
      "none", "not_finite", "heading", "world", "speed", "jump", "frozen", "time"};
  return names[static_cast<std::size_t>(fault)];
}

Track::Track(const Model& model, std::size_t input_at, const TrackLimits& limits)
    : model_(model),
      input_at_(input_at),
      limits_(limits),
      x_(static_cast<std::size_t>(model.nx())),
      last_(x_),
      drift_(x_),
      scratch_(RungeKuttaScratch::rows_needed * x_.size()),
      no_input_(static_cast<std::size_t>(model.nu())) {
  model.at_rest({{}, {1.0, 0.0}}, x_.data());
}

MeasurementFault Track::take(std::span<const double> x, double stamp, double now, const InputHistory& history,
                             double sigma) noexcept {
  if (!(stamp > last_stamp_)) return MeasurementFault::none;
  const auto fault = [&](MeasurementFault reason) {
    trusted_ = false;
    streak_ = 0;
    return reason;
  };
  if (stamp > now + ahead_max || stamp < now - limits_.oldest) return fault(MeasurementFault::time);
  last_stamp_ = stamp;
  if (const MeasurementFault reason = implausible(x); reason != MeasurementFault::none) return fault(reason);
  if (frozen(x, stamp, history)) return fault(MeasurementFault::frozen);

  const bool follows = sigma > 0 || reference_stamp_ == never || consistent(sight_, stamp);
  std::copy(x.begin(), x.end(), last_.begin());
  reference_ = sight_;
  reference_stamp_ = stamp;
  if (!follows) trusted_ = false;
  streak_ = follows ? streak_ + 1 : 1;
  if (!trusted_ && streak_ < limits_.accept_after) return MeasurementFault::jump;
  trusted_ = true;
  accept_measurement(x, stamp, now);
  return MeasurementFault::none;
}

void Track::begin(std::span<const double> x, double now) noexcept {
  accept_measurement(x, now, now);
  last_stamp_ = std::nextafter(now, never);
  reference_stamp_ = equal_since_ = never;
  streak_ = 0;
  trusted_ = true;
  is_frozen_ = false;
}

MeasurementFault Track::implausible(std::span<const double> x) noexcept {
  if (!all_finite(x)) return MeasurementFault::not_finite;
  sight_ = model_.sight(x.data(), no_input_.data());
  const double circle = norm(sight_.d.x, sight_.d.y);
  if (!(std::abs(circle - 1.0) <= off_the_circle)) return MeasurementFault::heading;
  for (const double p : {sight_.p.x, sight_.p.y, sight_.p.z}) {
    if (!(std::abs(p) <= limits_.world)) return MeasurementFault::world;
  }
  if (!(norm(sight_.v) <= limits_.v_max)) return MeasurementFault::speed;
  sight_.d = {sight_.d.x / circle, sight_.d.y / circle};
  return MeasurementFault::none;
}

bool Track::consistent(const Sight<double>& sight, double stamp) const noexcept {
  const double dt = stamp - reference_stamp_;
  const double step = limits_.v_max * dt + 3.0 * std::sqrt(6.0) * limits_.position_sigma;
  const double turn = limits_.turn_max * dt + 3.0 * std::sqrt(2.0) * limits_.heading_sigma;
  return norm(sight.p - reference_.p) <= step && chord(sight.d, reference_.d) <= turn;
}

bool Track::frozen(std::span<const double> x, double stamp, const InputHistory& history) noexcept {
  if (reference_stamp_ == never || stamp - reference_stamp_ > limits_.oldest || !equal_bits(x, last_)) {
    is_frozen_ = false;
    equal_since_ = never;
    return false;
  }
  if (is_frozen_) return true;
  if (equal_since_ == never) {
    equal_since_ = drift_time_ = reference_stamp_;
    std::copy(x.begin(), x.end(), drift_.begin());
  }
  carry(drift_, drift_time_, stamp, history);
  drift_time_ = stamp;
  if (stamp - equal_since_ < limits_.frozen_after) return false;
  const Sight<double> drift = model_.sight(drift_.data(), no_input_.data());
  const double far = moved_by + 3.0 * limits_.position_sigma, round = turned_by + 3.0 * limits_.heading_sigma;
  is_frozen_ = norm(drift.p - sight_.p) > far || chord(drift.d, sight_.d) > round;
  if (!is_frozen_) return false;
  std::copy(drift_.begin(), drift_.end(), x_.begin());
  time_ = drift_time_;
  stamp_ = equal_since_;
  return true;
}

void Track::accept_measurement(std::span<const double> x, double stamp, double now) noexcept {
  std::copy(x.begin(), x.end(), x_.begin());
  stamp_ = time_ = std::min(stamp, now);
}

void Track::predict(double now, const InputHistory& history) noexcept {
  if (!known()) return;
  carry(x_, time_, now, history);
  time_ = std::max(time_, now);
}

void Track::carry(std::vector<double>& x, double from, double to, const InputHistory& history) noexcept {
  const double late = limits_.command_delay;
  sightline::carry(model_, x, history, input_at_, from - late, to - late, {}, scratch_);
}

}  // namespace sightline
