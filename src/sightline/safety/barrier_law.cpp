#include "sightline/safety/barrier_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sightline/safety/projection.hpp"

namespace sightline {
namespace {

constexpr double least_ample = 0.3;  // [m]

/// tau / (1 - c tau): a quantity that settles with the lag tau moves a velocity with drag as far as
/// an impulse of this times it.
double impulse_of(const Model& model, double drag, double lag) {
  constexpr double most = 0.9;
  if (drag * lag > most) {
    throw std::invalid_argument(
        fmt::format("barrier: \"{}\" has a lag of {:.3g} s and a drag of {:.3g} /s, expected a product <= {}",
                    model.name(), lag, drag, most));
  }
  return lag / (1.0 - drag * lag);
}

}  // namespace

BarrierLaw::BarrierLaw(const Model& robot, const Authority& ability, double period,
                       const BarrierOptions& given)
    : model(robot),
      options(validate(given, period)),
      dt(period),
      parts(EscapePlans::parts(dt)),
      can(ability),
      b(given.authority * can.acceleration),
      predicted(),
      next_predicted(),
      plans(can.drag, dt, can.thrust_lag),
      ample(std::max(least_ample, 2 * can.push * (plans.F(dt) + plans.E(dt) * plans.E_longest()))),
      maneuvers(can.drag, can.climbs ? can.climb : 0.0) {
  options.residual_acceleration += can.misfit;
  if (can.thrust_lag > 0) {
    const double c = can.drag, tau = impulse_of(model, c, can.thrust_lag);
    if (can.climb_lag > 0)
      per_beside = can.lift * can.thrust_most * impulse_of(model, c, can.climb_lag) / square(can.climb_lag);
    if (can.turn_lag > 0) {
      // The command keeps its direction in V for a period, while the heading turns.
      const double held = can.turn_lag * (std::exp(dt / can.turn_lag) - 1.0);
      const double turned = can.thrust_most + can.acceleration * held / can.thrust_lag;
      per_rate = turned * tau * impulse_of(model, c, can.turn_lag);
    }
    ample =
        ample * tau / can.thrust_lag + settling(2 * dt * can.climb, 2 * dt * can.turn) * plans.E_longest();
  }
  const double w = options.residual_acceleration;
  if (w > 0 && (can.drives() || w >= b)) {
    throw std::invalid_argument(fmt::format(
        "barrier: residual_acceleration = {} m/s^2, expected {}", w,
        can.drives() ? fmt::format("0 with \"{}\", which stands by its model alone", model.name())
                     : fmt::format("< {:.3g}, the acceleration of the plans of \"{}\"", b, model.name())));
  }
  // p + tau v deviates as both do, and w itself adds tau w to its velocity.
  const auto deviation = [&, tau = can.thrust_lag](double t) {
    const double E = plans.E(t);
    Deviation of{w * plans.F(t), w * E};
    if (tau > 0) of = {of.p + tau * w * E, (1.0 - can.drag * tau) * w * E + tau * w};
    return of;
  };
  predicted = deviation(options.command_delay);
  next_predicted = deviation(options.command_delay + dt);
  options.floor += options.wall_margin;
  options.ceiling -= options.wall_margin;
  // A period may begin and end within the bounds, and exceed them in between.
  const double margin = options.wall_margin + 0.15 * can.push * square(dt / parts);
  options.world -= margin;
  for (const Zone& zone : options.zones) {
    for (ForbiddenPiece& piece : forbidden_pieces(zone)) {
      for (Face& face : piece.faces) face.offset += margin;
      piece.low -= options.wall_margin;
      piece.high += options.wall_margin;
      pieces.push_back(std::move(piece));
    }
  }
  Arena arena{.disc = b};
  for (std::size_t k = 0; can.thrust_count == 2 && k < 2; ++k)
    arena.g[k] = {given.authority * can.thrusts[k].x, given.authority * can.thrusts[k].y};
  for (std::size_t i = 0; i < joint.size(); ++i)
    joint[i] = EvasiveManeuvers::thrust(arena, EvasiveManeuvers::heading(i));
}

NextState BarrierLaw::next(std::span<const double> x, std::span<const double> u) const noexcept {
  std::array<double, most_states> state;
  std::copy(x.begin(), x.end(), state.begin());
  for (int k = 0; k < parts; ++k) model.step(state.data(), u.data(), dt / parts);
  const Sight<double> seen = model.sight(state.data(), u.data()), there = settled(seen);
  return {there.p, seen.d, {seen.v.x, seen.v.y}, seen.p.z - there.p.z, lagging(state, seen)};
}

Flown BarrierLaw::flown(std::span<const double> x, std::span<const double> u) const noexcept {
  Flown flown;
  std::array<double, most_states> state;
  std::copy(x.begin(), x.end(), state.begin());
  for (int k = 1; k < parts; ++k) {
    model.step(state.data(), u.data(), dt / parts);
    flown.between.push_back(model.sight(state.data(), u.data()).p);
  }
  flown.after = next(x, u);
  return flown;
}

Stop BarrierLaw::stop(double speed, double part) const noexcept {
  constexpr double period_rounding = 1e-6;  // of a period
  if (speed <= still) return {};
  const double periods = std::max(1.0, std::ceil(stopping_time(-speed, part) / dt - period_rounding));
  const double a = part * b;
  const EscapeShape whole = plans.shape((periods - 1) * dt), last = plans.shape(dt);
  const double v = std::max(0.0, whole.e * speed - whole.E * a);  // at the beginning of the last period
  return {periods * dt, whole.E * speed - whole.F * a + v * (last.E - last.e / last.E * last.F),
          periods > 1 ? last.e * speed - last.E * a : 0.0};
}

Sight<double> BarrierLaw::settled(Sight<double> self) const noexcept {
  if (can.climb_lag > 0) self.p.z += can.climb_lag * self.v.z;
  return self;
}

Lagging BarrierLaw::lagging(std::span<const double> x, const Sight<double>& seen) const noexcept {
  if (can.thrust_lag == 0) return {};
  const double rate = can.rate_state < 0 ? 0.0 : x[static_cast<std::size_t>(can.rate_state)];
  return {rotate(seen.d, Vec2<double>{gravity * seen.lean.x, gravity * seen.lean.y}), rate};
}

BarrierLaw::Point BarrierLaw::leading(const Vec3<double>& p, const Vec2<double>& v,
                                      const Lagging& late) const noexcept {
  const double tau = can.thrust_lag, share = 1.0 - can.drag * tau;
  if (tau == 0) return {p, v};
  return {p + tau * Vec3<double>{v.x, v.y, 0.0},
          {share * v.x + tau * late.a.x, share * v.y + tau * late.a.y}};
}

BarrierLaw::Outcome BarrierLaw::outcome_of(const Sight<double>& self, const Lagging& late,
                                           const Vec2<double>& a, double rise) const noexcept {
  if (can.thrust_lag > 0) {
    const double left = std::exp(-dt / can.thrust_lag);
    return {a.x + left * (late.a.x - a.x), a.y + left * (late.a.y - a.y), self.p.z + rise};
  }
  const EscapeShape step = plans.shape(dt);
  return {step.e * self.v.x + step.E * a.x, step.e * self.v.y + step.E * a.y, self.p.z + rise};
}

BarrierLaw::Outcome BarrierLaw::outcome_of_held(const Sight<double>& self, const NextState& coasting,
                                                const Vec2<double>& a) const noexcept {
  const double share = 1.0 - std::exp(-dt / can.thrust_lag);
  const Vec2<double> turned = rotate(coasting.d, rotate<double>({self.d.x, -self.d.y}, a)),
                     &left = coasting.lagging.a;
  return {left.x + share * turned.x, left.y + share * turned.y, self.p.z};
}

double BarrierLaw::braking(double part) const noexcept {
  constexpr double least = 0.05;  // of narrower limits
  return std::max(part * b - options.residual_acceleration, least * part * b);
}

double BarrierLaw::stopping_time(double away, double part) const noexcept {
  const double c = can.drag, most = braking(part);
  return away >= 0 ? 0.0 : c > 1e-6 ? std::log1p(-away * c / most) / c : -away / most;
}

double BarrierLaw::braked(const BoundPlane& plane, const Point& from, const Deviation& settling,
                          double part) const noexcept {
  const auto& [p, v] = from;
  if (can.drives()) {
    const double speed = norm(v.x, v.y), towards = std::min(dot(plane.n, v), 0.0);
    return plane.offset + plane.n.x * p.x + plane.n.y * p.y +
           (towards < 0 ? stop(speed, part).length * towards / speed : 0.0);
  }
  const double counts = settling_part(dot(plane.n, v) - predicted.v, part);
  const double away = std::min(dot(plane.n, v) - predicted.v - counts * settling.v, 0.0),
               stop = stopping_time(away, part);
  return plane.offset + plane.n.x * p.x + plane.n.y * p.y - predicted.p - counts * settling.p +
         plans.E(stop) * away + braking(part) * plans.F(stop);
}

void BarrierLaw::reach_for(std::span<const double> x, const Outcome& wanted, std::span<const double> u_min,
                           std::span<const double> u_max, std::span<double> u) const noexcept {
  const auto outcome = [&] {
    const NextState n = next(x, u);
    const Vec2<double>& level = can.thrust_lag > 0 ? n.lagging.a : n.v;
    return Outcome{level.x, level.y, n.p.z};
  };
  // du = J' (J J' + tiny)^-1 (wanted - outcome), the least-norm solution.
  const Outcome now = outcome();
  std::array<std::array<double, 3>, most_inputs> J{};
  for (std::size_t k = 0; k < u.size(); ++k) {
    if (can.reach[k] == 0) continue;  // yaw would turn the plan's thrust
    constexpr double difference = 1e-3;
    const double at = u[k];
    u[k] = at + difference;
    const Outcome there = outcome();
    u[k] = at;
    for (std::size_t i = 0; i < 3; ++i) J[k][i] = (there[i] - now[i]) / difference;
  }
  constexpr double tiny = 1e-12;
  std::array<std::array<double, 3>, 3> L{};
  std::array<double, 3> y{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = i == j ? tiny : 0.0;
      for (std::size_t k = 0; k < u.size(); ++k) sum += J[k][i] * J[k][j];
      for (std::size_t k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      L[i][j] = i == j ? std::sqrt(std::max(sum, tiny)) : sum / L[j][j];
    }
    y[i] = wanted[i] - now[i];
    for (std::size_t k = 0; k < i; ++k) y[i] -= L[i][k] * y[k];
    y[i] /= L[i][i];
  }
  for (std::size_t i = 3; i-- > 0;) {
    for (std::size_t k = i + 1; k < 3; ++k) y[i] -= L[k][i] * y[k];
    y[i] /= L[i][i];
  }
  for (std::size_t k = 0; k < u.size(); ++k) {
    const double moved = u[k] + J[k][0] * y[0] + J[k][1] * y[1] + J[k][2] * y[2];
    u[k] = std::clamp(std::isfinite(moved) ? moved : 0.0, u_min[k], u_max[k]);
  }
}

}  // namespace sightline
