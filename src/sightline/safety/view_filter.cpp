#include "sightline/safety/view_filter.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "sightline/model/state_roles.hpp"

namespace sightline {
namespace {

constexpr double decay_rate = 4.0;  // greatest decay rate of a reserve [1/s]
constexpr double strict = 1e-5;     // below this a reserve may not fall [m]
constexpr double reserve_rounding = 1e-7;
constexpr double exact = 1e-6;  // of predictions by the same model [m], [m/s]

/// (1 - e^{-c t}) / c and its integral over t, by their series.
std::array<double, 2> responses(double c, double t) {
  double E = 0.0, F = 0.0, term = 1.0;
  for (int k = 0; k < 20; ++k) {
    E += term / (k + 1), F += term / ((k + 1) * (k + 2));
    term *= -c * t / (k + 1);
  }
  return {t * E, t * t * F};
}

/// Greatest change of the velocity by the wind in a period [m/s].
double pushed(const ViewTask& task) {
  const ViewMotion& robot = task.motion;
  const double drag =
      robot.across.input < 0 ? robot.along.drag : std::min(robot.along.drag, robot.across.drag);
  return task.bounds.wind * responses(drag, task.dt)[0];
}

/// What a reserve must be at the next sample: at least a part of what it is, or S itself.
struct Need {
  double soft, hard;
};
Need need_of(double reserve, double keep) {
  const double hard = std::min(reserve, strict);
  return {std::max(keep * reserve, hard), hard};
}

}  // namespace

std::string_view to_string(ViewReserve reserve) noexcept {
  constexpr std::array<std::string_view, 12> names = {"near", "far",   "left",     "right",
                                                      "high", "low",   "sideward", "command",
                                                      "age",  "error", "speed",    "motion"};
  return names[static_cast<std::size_t>(reserve)];
}

SlowEstimate::SlowEstimate(const ViewBounds& bounds, double dt) noexcept
    : step_(bounds.error > 0 ? bounds.known(dt).speed * dt : infinity),
      climb_(bounds.error > 0 ? bounds.known(dt).climb * dt : infinity) {}

const Vec3<double>& SlowEstimate::follow(const Vec3<double>& measured) noexcept {
  if (!has_begun_) p_ = measured, has_begun_ = true;
  const Vec2<double> off = {measured.x - p_.x, measured.y - p_.y};
  const double distance = norm(off.x, off.y), part = distance > step_ ? step_ / distance : 1.0;
  p_ = {p_.x + part * off.x, p_.y + part * off.y, p_.z + std::clamp(measured.z - p_.z, -climb_, climb_)};
  return p_;
}

SlowState::SlowState(const Model& model, const ViewTask& task)
    : model_(model),
      dt_(task.dt),
      most_v_(pushed(task)),
      most_p_(view_prediction(task.bounds, task.dt).speed * task.dt),
      x_(size(model.nx())) {
  assert(x_.size() <= ViewFilter::most_states && "the filter of a view has as many states at most");
  const StateRoles roles = roles_of(model);
  for (const int k : std::span(roles.position).first(2))
    if (k >= 0) position_.push_back(size(k));
  for (const int k : roles.velocities)
    if (k != roles.velocity_G[2]) velocity_.push_back(size(k));
}

void SlowState::begin(std::span<const double> x) noexcept {
  std::copy(x.begin(), x.end(), x_.begin());
  is_late_ = false, lag_ = velocity_lag_ = 0.0;
}

void SlowState::follow(std::span<const double> u, std::span<const double> x, bool predicted) noexcept {
  is_late_ = is_late_ || predicted;
  if (!is_late_) return begin(x);
  std::array<double, ViewFilter::most_states> moved;
  std::copy(x_.begin(), x_.end(), moved.begin());
  model_.step(moved.data(), u.data(), dt_);
  std::copy(x.begin(), x.end(), x_.begin());
  // A distance beyond the greatest correction remains.
  const auto keep = [&](std::span<const std::size_t> states, double most) {
    double off = 0.0;
    for (const std::size_t k : states) off = norm(off, moved[k] - x[k]);
    const double rest = off > most + exact ? (off - most) / off : 0.0;
    for (const std::size_t k : states) x_[k] += rest * (moved[k] - x[k]);
    return rest * off;
  };
  velocity_lag_ = keep(velocity_, most_v_);
  lag_ = keep(position_, most_p_);
}

/// The target in coordinates of the certificate.
struct ViewFilter::Place {
  double r, theta, h;
  double v_f, v_s;  // relative to the target's known velocity, in V [m/s]
  double spare;     // of the vertical speed and yaw rate, where they lag [m/s], [rad/s]
};

/// Values from low to high that a command may have.
struct ViewFilter::Interval {
  double low = -infinity, high = infinity;            // by the decay rate
  double hard_low = -infinity, hard_high = infinity;  // by S

  /// The nearest value to `wanted`, within the limits.
  double nearest(double wanted, double least, double most) const noexcept {
    double from = low, to = high;
    if (from > to) {
      const double middle = 0.5 * (low + high);
      from = to = std::clamp(middle, std::min(hard_low, hard_high), std::max(hard_low, hard_high));
    }
    return std::clamp(std::clamp(wanted, from, to), least, most);
  }
};

struct ViewFilter::Period {
  struct Span {
    double least, greatest;
  };
  std::span<const double> x, u_min, u_max;
  std::array<double, most_inputs> wanted;
  ViewTarget later;  // the target at the next sample, if it keeps its known velocity
  Place at;
  ViewReserves reserves;
  Place next{};             // under the command,
  bool is_current = false;  // unless the command has changed since

  double nominal(const ViewMotion::Axis& axis) const noexcept {
    return axis.input < 0 ? 0.0 : axis.gain * wanted[size(axis.input)];
  }
  /// The limits of an axis (gain u), at most `most` in both directions.
  Span span(const ViewMotion::Axis& axis, double most) const noexcept {
    const auto k = size(axis.input);
    const double a = axis.gain * u_min[k], b = axis.gain * u_max[k];
    const double least = std::min(a, b), greatest = std::max(a, b);
    return {std::clamp(-most, least, greatest), std::clamp(most, least, greatest)};
  }
  /// Part of the way from a value of an axis that its limits allow.
  double part(const ViewMotion::Axis& axis, double from, double way) const noexcept {
    if (axis.input < 0) return 1.0;
    const Span within = span(axis, axis.most);
    const double beyond = std::max(from + way - within.greatest, within.least - from - way);
    return beyond <= 0 ? 1.0 : std::max(0.0, 1.0 - beyond / std::abs(way));
  }
  /// Puts the value of an axis into u.
  void put(const ViewMotion::Axis& axis, double value, std::span<double> u) noexcept {
    if (axis.input < 0) return;
    const auto k = size(axis.input);
    const double before = u[k];
    u[k] = value == nominal(axis) ? wanted[k] : std::clamp(value / axis.gain, u_min[k], u_max[k]);
    is_current = is_current && u[k] == before;
  }
  /// Puts the value of an axis nearest to the wanted one into u, at most `most`.
  void choose(const ViewMotion::Axis& axis, const Interval& interval, double most,
              std::span<double> u) noexcept {
    const Span within = span(axis, most);
    put(axis, interval.nearest(nominal(axis), within.least, within.greatest), u);
  }
};

ViewFilter::ViewFilter(const Model& model, const ViewCertificate& certificate)
    : model_(model), certificate_(certificate) {
  const ViewTask& task = certificate.task;
  const double dt = task.dt;
  if (!certificate.exists()) throw_invalid("no certificate of the view exists, expected one");
  if (model.nx() > most_states || model.nu() > most_inputs)
    throw_invalid("\"{}\" has {} states and {} inputs, expected at most {} and {}", model.name(), model.nx(),
                  model.nu(), most_states, most_inputs);
  if (!(dt > 0 && dt <= longest_period))
    throw_invalid("period = {}, expected in (0, {}] s for a certified view", dt, longest_period);
  const Vec2<double> drags = task.motion.drags();
  const auto [E, F] = responses(drags.x, dt);
  const double wind = task.bounds.wind;
  const ViewBounds::Known known = task.bounds.known(dt);
  unknown_.climbs = (known.climb + task.odometry.velocity) * dt, unknown_.turns = task.odometry.turn * dt;
  E_ = E, F_ = F, E_across_ = responses(drags.y, dt)[0];
  keep_ = 1 - decay_rate * dt;
  if (task.bounds.is_velocity_measured()) {
    const double A = task.bounds.acceleration;
    unknown_.moves = 0.5 * A * dt * dt + wind * F, unknown_.speeds = A * dt + pushed(task);
  } else {
    unknown_.moves = known.speed * dt + wind * F, unknown_.speeds = pushed(task);
  }
  unknown_.moves += view_prediction(task.bounds, dt).speed * dt;
}

ViewFilter::Place ViewFilter::place(std::span<const double> x, std::span<const double> u,
                                    const ViewTarget& target) const noexcept {
  const Sight<double> robot = model_.sight(x.data(), u.data());
  const ViewMotion& motion = certificate_.task.motion;
  const Vec2<double> ahead = rotate(robot.d, motion.ahead), back = {ahead.x, -ahead.y};
  const Vec2<double> q = rotate(back, {target.p.x - robot.p.x, target.p.y - robot.p.y});
  const bool measured = certificate_.task.bounds.is_velocity_measured();
  const Vec2<double> w = measured ? target.v : Vec2<double>{};
  const Vec2<double> v = rotate(back, {robot.v.x - w.x, robot.v.y - w.y});
  Place at = {norm(q.x, q.y), std::atan2(q.y, q.x), robot.p.z - target.p.z, v.x, v.y, infinity};
  // A rate that lags leads to this height and heading, which follow the command at once.
  if (motion.climb.lag > 0) {
    at.h += motion.climb.lag * robot.v.z;
    at.spare = certificate_.climb - std::abs(robot.v.z);
  }
  if (motion.turn.lag > 0) {
    const double turn = x[size(motion.rate_state)];
    at.theta = wrap_angle(at.theta - motion.turn.lag * turn);
    at.spare = std::min(at.spare, certificate_.turn - std::abs(turn));
  }
  return at;
}

const ViewFilter::Place& ViewFilter::next(Period& now, std::span<const double> u) const noexcept {
  if (now.is_current) return now.next;
  std::array<double, most_states> state;
  std::copy(now.x.begin(), now.x.end(), state.begin());
  model_.step(state.data(), u.data(), certificate_.task.dt);
  now.next = place(std::span(state).first(now.x.size()), u, now.later);
  now.is_current = true;
  return now.next;
}

double ViewFilter::least_gap(const std::vector<double>& heights, double r, double beside,
                             double sign) const noexcept {
  const ViewCertificate& z = certificate_;
  double least = std::min(sign * z.at(heights, r - beside), sign * z.at(heights, r + beside));
  const double last = static_cast<double>(heights.size() - 1);
  const double from = std::max(0.0, std::ceil((r - beside - z.near) / z.step())),
               to = std::min(last, std::floor((r + beside - z.near) / z.step()));
  for (double k = from; k <= to; ++k) least = std::min(least, sign * heights[static_cast<std::size_t>(k)]);
  return least;
}

/// By how much the bearing of a target at the distance r may differ.
double ViewFilter::Unknown::bearing(double r) const noexcept {
  return (moves < r ? std::asin(moves / r) : std::numbers::pi) + turns;
}

/// Reserves at a place, if the motion is known but for `unknown`.
ViewReserves ViewFilter::reserves(const Place& at, const Unknown& unknown) const noexcept {
  const ViewCertificate& z = certificate_;
  const double off = unknown.bearing(at.r);
  return {at.r - unknown.moves - z.near - z.brake.distance(at.v_f + unknown.speeds),
          z.far - at.r - unknown.moves - z.brake.distance(unknown.speeds - at.v_f),
          (z.theta - at.theta - off) * at.r,
          (z.theta + at.theta - off) * at.r,
          least_gap(z.high, at.r, unknown.moves, 1.0) - unknown.climbs - at.h,
          least_gap(z.low, at.r, unknown.moves, -1.0) - unknown.climbs + at.h,
          std::min(at.spare,
                   z.task.motion.across.input < 0 ? z.far : z.sideward - unknown.speeds - std::abs(at.v_s))};
}

ViewReserves ViewFilter::reserves(std::span<const double> x, const ViewTarget& target) const noexcept {
  const std::array<double, most_inputs> none{};
  return reserves(place(x, none, target), {});
}

/// Accelerations along and across `ahead` by a command.
Vec2<double> ViewFilter::pushes(std::span<const double> u) const noexcept {
  const ViewMotion& motion = certificate_.task.motion;
  const auto pushed = [&](const ViewMotion::Axis& axis) {
    return axis.input < 0 ? 0.0 : axis.gain * u[size(axis.input)];
  };
  return rotate<double>({motion.ahead.x, -motion.ahead.y}, {pushed(motion.along), pushed(motion.across)});
}

ViewFilter::Interval ViewFilter::push_across(const Place& then, double value) const noexcept {
  if (certificate_.task.motion.across.input < 0) return {};
  const double room = certificate_.sideward - unknown_.speeds;
  Interval interval;
  interval.low = interval.hard_low = value + (-room - then.v_s) / E_across_;
  interval.high = interval.hard_high = value + (room - then.v_s) / E_across_;
  return interval;
}

/// Largest a with  gap + r_per_a (a - a0) - n(v + E (a - a0)) >= need. Newton's method on a concave
/// function.
double ViewFilter::largest_push(double gap, double v, double a0, double r_per_a, double need) const noexcept {
  constexpr double settled = 1e-10;  // [m/s^2]
  double a = certificate_.task.motion.most_push().x;
  for (int k = 0; k < 12; ++k) {
    const double then = v + E_ * (a - a0);
    const double left = gap + r_per_a * (a - a0) - certificate_.brake.distance(then) - need;
    if (k == 0 && left >= 0) return infinity;
    const double change = left / (E_ * certificate_.brake.slope(then) - r_per_a);
    a += change;
    if (std::abs(change) < settled) break;
  }
  return a;
}

ViewFilter::Interval ViewFilter::push_along(const Period& now, const Place& then,
                                            double value) const noexcept {
  const ViewCertificate& z = certificate_;
  const double per_push = -std::max(0.1, std::cos(then.theta)) * F_;
  const double near = then.r - unknown_.moves - z.near, far = z.far - then.r - unknown_.moves;
  const Need of_near = need_of(now.reserves[0], keep_), of_far = need_of(now.reserves[1], keep_);
  Interval interval;
  interval.high = largest_push(near, then.v_f + unknown_.speeds, value, per_push, of_near.soft);
  interval.low = -largest_push(far, unknown_.speeds - then.v_f, -value, per_push, of_far.soft);
  if (interval.low > interval.high) {
    interval.hard_high = largest_push(near, then.v_f + unknown_.speeds, value, per_push, of_near.hard);
    interval.hard_low = -largest_push(far, unknown_.speeds - then.v_f, -value, per_push, of_far.hard);
  }
  return interval;
}

/// Accelerates as wanted, or nearest to it in both intervals. If the limits of the inputs forbid that, from
/// the nearest within the certificate's rectangle, which they allow, as far towards it as they allow.
void ViewFilter::push(Period& now, std::span<double> u) const noexcept {
  const ViewMotion& motion = certificate_.task.motion;
  const Vec2<double> b = certificate_.push, most = motion.most_push();
  const Vec2<double> value = pushes(u), wanted = pushes(now.wanted);
  const Place& then = next(now, u);
  const Interval along = push_along(now, then, value.x), across = push_across(then, value.y);
  const Vec2<double> aim = {along.nearest(wanted.x, -most.x, most.x),
                            across.nearest(wanted.y, -most.y, most.y)};
  const Vec2<double> sure = {std::clamp(aim.x, -b.x, b.x), std::clamp(aim.y, -b.y, b.y)};
  const Vec2<double> from = rotate(motion.ahead, sure),
                     way = rotate<double>(motion.ahead, {aim.x - sure.x, aim.y - sure.y});
  const double part = std::min(now.part(motion.along, from.x, way.x), now.part(motion.across, from.y, way.y));
  const bool is_wanted = part == 1 && aim.x == wanted.x && aim.y == wanted.y;
  now.put(motion.along, is_wanted ? now.nominal(motion.along) : from.x + part * way.x, u);
  now.put(motion.across, is_wanted ? now.nominal(motion.across) : from.y + part * way.y, u);
}

void ViewFilter::climb(Period& now, std::span<double> u) const noexcept {
  const ViewCertificate& z = certificate_;
  const ViewMotion::Axis& axis = z.task.motion.climb;
  if (axis.input < 0) return;
  const double dt = z.task.dt, value = axis.gain * u[size(axis.input)];
  const ViewReserves then = reserves(next(now, u), unknown_);
  const Need high = need_of(now.reserves[4], keep_), low = need_of(now.reserves[5], keep_);
  now.choose(axis,
             {.low = value + (low.soft - then[5]) / dt,
              .high = value + (then[4] - high.soft) / dt,
              .hard_low = value + (low.hard - then[5]) / dt,
              .hard_high = value + (then[4] - high.hard) / dt},
             z.climb, u);
}

void ViewFilter::turn(Period& now, std::span<double> u) const noexcept {
  const ViewCertificate& z = certificate_;
  const ViewMotion::Axis& axis = z.task.motion.turn;
  const double dt = z.task.dt, value = axis.gain * u[size(axis.input)];
  const Place& at = next(now, u);
  const double off = unknown_.bearing(at.r);
  // A turn also moves the robot: theta+ falls by this much per yaw rate.
  const double per_rate = dt * (1 + 0.5 * dt * (at.v_f * std::cos(at.theta) + at.v_s * std::sin(at.theta)) /
                                        std::max(at.r, 0.05));
  const Need left = need_of(now.reserves[2] / now.at.r, keep_),
             right = need_of(now.reserves[3] / now.at.r, keep_);
  const double over = at.theta + off - z.theta, under = at.theta - off + z.theta;
  now.choose(axis,
             {.low = value + (over + left.soft) / per_rate,
              .high = value + (under - right.soft) / per_rate,
              .hard_low = value + (over + left.hard) / per_rate,
              .hard_high = value + (under - right.hard) / per_rate},
             z.turn, u);
}

ViewFilterResult ViewFilter::judge(Period& now, std::span<const double> u) const noexcept {
  const ViewReserves then = reserves(next(now, u), unknown_);
  const auto least = std::min_element(now.reserves.begin(), now.reserves.end());
  const auto keeps = [&](const ViewMotion::Axis& axis, double most) {
    return axis.input < 0 || std::abs(axis.gain * u[size(axis.input)]) <= most * (1 + 1e-9);
  };
  ViewFilterResult result;
  result.reserve = *least;
  result.least = static_cast<ViewReserve>(least - now.reserves.begin());
  result.certified = *least >= -reserve_rounding &&
                     *std::min_element(then.begin(), then.end()) >= -reserve_rounding &&
                     keeps(certificate_.task.motion.turn, certificate_.turn) &&
                     keeps(certificate_.task.motion.climb, certificate_.climb);
  return result;
}

ViewFilter::Period ViewFilter::period(std::span<const double> x, const ViewTarget& target,
                                      std::span<const double> u) const noexcept {
  const double dt = certificate_.task.dt;
  Period now{.x = x, .u_min = {}, .u_max = {}, .wanted = {}, .later = target, .at = {}, .reserves = {}};
  if (certificate_.task.bounds.is_velocity_measured())
    now.later.p = {target.p.x + dt * target.v.x, target.p.y + dt * target.v.y, target.p.z};
  now.at = place(x, u, target);
  now.reserves = reserves(now.at, {});
  return now;
}

ViewFilterResult ViewFilter::judge(std::span<const double> x, const ViewTarget& target,
                                   std::span<const double> u) const noexcept {
  Period now = period(x, target, u);
  return judge(now, u);
}

ViewFilterResult ViewFilter::filter(std::span<const double> x, const ViewTarget& target,
                                    std::span<const double> u_min, std::span<const double> u_max,
                                    std::span<double> u) const noexcept {
  assert(u.size() == size(model_.nu()) && x.size() == size(model_.nx()) &&
         "state and command have as many numbers as the model");
  bool active = false;
  for (std::size_t k = 0; k < u.size(); ++k) {
    const double wanted = u[k];
    u[k] = std::clamp(std::isfinite(wanted) ? wanted : 0.0, u_min[k], u_max[k]);
    active = active || u[k] != wanted;
  }
  if (!all_finite(x) || !std::isfinite(norm(target.p)) || !std::isfinite(norm(target.v.x, target.v.y)))
    return {.active = active};
  Period now = period(x, target, u);
  now.u_min = u_min, now.u_max = u_max;
  std::copy(u.begin(), u.end(), now.wanted.begin());
  // A turn changes r and v by terms of dt^2, and so the other intervals: a few passes.
  constexpr int passes = 5;
  constexpr double settled = 1e-9;
  for (int pass = 0; pass < passes; ++pass) {
    std::array<double, most_inputs> before{};
    std::copy(u.begin(), u.end(), before.begin());
    push(now, u);
    turn(now, u);
    double change = 0.0;
    for (std::size_t k = 0; k < u.size(); ++k) change = std::max(change, std::abs(u[k] - before[k]));
    if (change < settled) break;
  }
  climb(now, u);
  ViewFilterResult result = judge(now, u);
  result.active = active || !std::equal(u.begin(), u.end(), now.wanted.begin());
  return result;
}

}  // namespace sightline
