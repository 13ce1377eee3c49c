#include "sightline/safety/escape.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace sightline {
namespace {

constexpr double tiny_length = 1e-9;

/// v / |v|, or `other` where v has no direction.
Vec2<double> direction(const Vec2<double>& v, const Vec2<double>& other) {
  const double length = std::sqrt(dot(v, v));
  return length > tiny_length ? Vec2<double>{v.x / length, v.y / length} : other;
}

/// Whether the plan climbed or sank, and has done so as far as it may.
bool is_level(const Tube& tube, double t) { return tube.climb != 0 && std::abs(tube.climb) * t >= tube.room; }

/// By how much it has climbed [m].
double risen(const Tube& tube, double t) { return std::clamp(tube.climb * t, -tube.room, tube.room); }

/// The allowed acceleration that leads farthest along a direction.
Vec2<double> farthest(const Tube& tube, const Vec2<double>& along) {
  if (tube.thrust_count == 0) return {tube.beta * along.x, tube.beta * along.y};
  Vec2<double> a;
  for (int k = 0; k < tube.thrust_count; ++k) {
    const Vec2<double>& g = tube.thrusts[static_cast<std::size_t>(k)];
    const double side = std::copysign(1.0, dot(g, along));
    a = {a.x + side * g.x, a.y + side * g.y};
  }
  return a;
}

}  // namespace

/// q_a and f_a at one t, with derivatives.
struct EscapePlans::Point {
  Vec3<double> q, n;
  Shape shape;
  double f = 0.0, slope = 0.0, curvature = 0.0;
};

EscapePlans::EscapePlans(double drag, double dt)
    : c_(drag), per_c_(drag > 0 ? 1.0 / drag : 0.0), dt_(dt), e_back_(std::exp(drag * dt)) {
  // Closer at the beginning, where most is decided.
  for (std::size_t i = 0; i < times; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(times - 1);
    t_[i] = dt + (longest - dt) * part * std::sqrt(part);
    E_[i] = E(t_[i]);
    F_[i] = F(t_[i]);
  }
}

double EscapePlans::E(double t) const noexcept { return shape(t).E; }
double EscapePlans::F(double t) const noexcept { return shape(t).F; }

EscapePlans::Shape EscapePlans::shape(double t) const noexcept {
  const double e = exp(-c_ * t);
  if (c_ * t < 1e-3) return {e, t * (1.0 - 0.5 * c_ * t), 0.5 * t * t * (1.0 - c_ * t / 3.0)};
  const double E = (1.0 - e) * per_c_;
  return {e, E, (t - E) * per_c_};
}

EscapePlans::Shape EscapePlans::left(const Touch& touch) const noexcept {
  const double t = touch.time - dt_;
  if (c_ * t < 1e-3) return shape(t);
  const double e = touch.shape.e * e_back_, E = (1.0 - e) * per_c_;
  return {e, E, (t - E) * per_c_};
}

EscapePlans::Point EscapePlans::at(const Tube& tube, const Vec2<double>& a, double t) const noexcept {
  Point p;
  p.shape = shape(t);
  const auto [e, E, F] = p.shape;
  p.q = {tube.r.x + E * tube.w.x + F * a.x - t * tube.drift.x,
         tube.r.y + E * tube.w.y + F * a.y - t * tube.drift.y, tube.r.z + risen(tube, t) - t * tube.drift.z};
  const Vec3<double> rate = {e * tube.w.x + E * a.x - tube.drift.x, e * tube.w.y + E * a.y - tube.drift.y,
                             (is_level(tube, t) ? 0.0 : tube.climb) - tube.drift.z};
  const Vec2<double> bend = {e * (a.x - c_ * tube.w.x), e * (a.y - c_ * tube.w.y)};
  const double squared = dot(p.q, p.q), length = std::sqrt(squared);
  const double inverse = length > tiny_length ? 1.0 / length : 0.0, along = dot(p.q, rate) * inverse;
  p.n = inverse * p.q;
  if (inverse == 0) {
    const Vec2<double> level = direction(a, tube.tie);
    p.n = {level.x, level.y, 0.0};
  }
  p.f = length - tube.rho0 - t * (tube.speed + 0.5 * tube.growth * t) - tube.spread * E;
  p.slope = along - tube.speed - tube.growth * t - tube.spread * e;
  p.curvature = (p.q.x * bend.x + p.q.y * bend.y + dot(rate, rate) - along * along) * inverse - tube.growth +
                c_ * tube.spread * e;
  return p;
}

Touch EscapePlans::touch(const Tube& tube, const Vec2<double>& a, double t) const noexcept {
  const Point p = at(tube, a, t);
  return {p.f, t, p.n, p.shape, is_level(tube, t), p.slope, p.curvature};
}

std::size_t EscapePlans::lowest(const Curve& f) noexcept {
  // The place rides in the last bits of f, where it is worth 1e-14 of it: one minimum finds both.
  constexpr std::uint64_t place = 31;
  constexpr std::size_t third = times / 3;
  static_assert(times <= place && third == 8);
  Curve g;
  for (std::size_t k = 0; k < times; ++k)
    g[k] = std::bit_cast<double>((std::bit_cast<std::uint64_t>(f[k]) & ~place) | k);
  for (std::size_t k = 0; k < third; ++k) g[k] = std::min(std::min(g[k], g[k + third]), g[k + 2 * third]);
  for (std::size_t half = third / 2; half > 0; half /= 2) {
    for (std::size_t k = 0; k < half; ++k) g[k] = std::min(g[k], g[k + half]);
  }
  return std::bit_cast<std::uint64_t>(g[0]) & place;
}

double EscapePlans::least_of(const Curve& f, std::size_t i) const noexcept {
  if (i == 0 || i + 1 == times) return t_[i];
  // The vertex of the parabola through three points.
  const double a = t_[i] - t_[i - 1], b = t_[i + 1] - t_[i], fa = f[i - 1] - f[i], fb = f[i + 1] - f[i];
  const double up = fa * b * b - fb * a * a, down = 2 * (fa * b + fb * a);
  return down > 0 ? t_[i] + std::clamp(up / down, -a, b) : t_[i];
}

[[gnu::flatten]] Touch EscapePlans::nearest(const Tube& tube, const Vec2<double>& a, const Curve& f,
                                            std::size_t i) const noexcept {
  double t = least_of(f, i);
  Point p = at(tube, a, t);
  constexpr double near = 1e-4;  // [s]
  for (int round = 0; round < 3 && p.curvature > 0; ++round) {
    const double next = std::clamp(t - std::clamp(p.slope / p.curvature, -0.25, 0.25), dt_, longest);
    const double step = std::abs(next - t);
    if (step < near) break;
    t = next;
    p = at(tube, a, t);
    if (step < 0.03) break;  // the next would be a thousandth of it
  }
  // The grid's least stands where the refinement went astray.
  if (f[i] - tube.rho0 < p.f) {
    t = t_[i];
    p = at(tube, a, t);
  }
  return {p.f, t, p.n, p.shape, is_level(tube, t), p.slope, p.curvature};
}

Escape EscapePlans::refined(const Tube& tube, const Vec2<double>& a, const Curve& f) const noexcept {
  const std::size_t i = lowest(f);
  Escape plan{};
  plan.count = 1;
  plan.now = norm(tube.r) - tube.rho0;
  plan.a = a;
  plan.touches[0] = nearest(tube, a, f, i);
  // Another least, nearly as low: a step could make it the lower one.
  constexpr double none = 1e300, nearly = 0.1;  // [m]
  Curve least;
  for (std::size_t k = 1; k + 1 < times; ++k) {
    const bool low = f[k] < f[k + 1] && f[k] <= f[k - 1];
    least[k] = low ? f[k] : none;
  }
  least[0] = f[0] < f[1] ? f[0] : none;
  least[times - 1] = least[i] = none;
  const std::size_t other = lowest(least);
  if (least[other] < plan.later() + tube.rho0 + nearly) {
    plan.touches[1] = nearest(tube, a, f, other);
    plan.count = 2;
  }
  return plan;
}

EscapePlans::Curve EscapePlans::curve(const Tube& tube, const Curve& x, const Curve& y) const noexcept {
  Curve f;
  const double half = 0.5 * tube.growth;
  Curve height;
  for (std::size_t k = 0; k < times; ++k) height[k] = tube.r.z - t_[k] * tube.drift.z;
  if (tube.climb != 0) {
    for (std::size_t k = 0; k < times; ++k) height[k] += risen(tube, t_[k]);
  }
  for (std::size_t k = 0; k < times; ++k) {
    const double t = t_[k], z = height[k];
    f[k] = std::sqrt(x[k] * x[k] + y[k] * y[k] + z * z) - t * (tube.speed + half * t) - tube.spread * E_[k];
  }
  return f;
}

EscapePlans::Curve EscapePlans::along(const Tube& tube, const Vec2<double>& a) const noexcept {
  Curve x, y;
  for (std::size_t k = 0; k < times; ++k) {
    x[k] = tube.r.x + E_[k] * tube.w.x + F_[k] * a.x - t_[k] * tube.drift.x;
    y[k] = tube.r.y + E_[k] * tube.w.y + F_[k] * a.y - t_[k] * tube.drift.y;
  }
  return curve(tube, x, y);
}

Escape EscapePlans::with(const Tube& tube, const Vec2<double>& a) const noexcept {
  return refined(tube, a, along(tube, a));
}

double EscapePlans::least(const Tube& tube, const Vec2<double>& a) const noexcept {
  const Curve f = along(tube, a);
  return std::min(norm(tube.r), f[lowest(f)]) - tube.rho0;
}

Escape EscapePlans::best(const Tube& tube) const noexcept {
  Curve x, y, a_x{}, a_y{};
  for (std::size_t k = 0; k < times; ++k) {
    x[k] = tube.r.x + E_[k] * tube.w.x - t_[k] * tube.drift.x;
    y[k] = tube.r.y + E_[k] * tube.w.y - t_[k] * tube.drift.y;
  }
  // The bound: at each time the a that is best for it.
  bool one_corner = tube.thrust_count > 0;
  for (std::size_t j = 0; j < static_cast<std::size_t>(tube.thrust_count); ++j) {
    const Vec2<double> g = tube.thrusts[j];
    double sides = 0.0;
    for (std::size_t k = 0; k < times; ++k) {
      const double side = g.x * x[k] + g.y * y[k] < 0 ? -1.0 : 1.0;
      a_x[k] += side * g.x;
      a_y[k] += side * g.y;
      sides += side;
    }
    one_corner = one_corner && std::abs(sides) == static_cast<double>(times);
  }
  if (tube.thrust_count == 0) {
    for (std::size_t k = 0; k < times; ++k) {
      const double out = tube.beta / std::sqrt(x[k] * x[k] + y[k] * y[k] + tiny_length * tiny_length);
      a_x[k] = out * x[k];
      a_y[k] = out * y[k];
    }
  }
  Curve x_out, y_out;
  for (std::size_t k = 0; k < times; ++k) {
    x_out[k] = x[k] + F_[k] * a_x[k];
    y_out[k] = y[k] + F_[k] * a_y[k];
  }
  const Curve f = curve(tube, x_out, y_out);
  if (one_corner) return refined(tube, {a_x[0], a_y[0]}, f);

  const Vec2<double> away = direction({tube.r.x, tube.r.y}, direction(tube.w, tube.tie));
  const auto best_at = [&](double t, double E) {
    const Vec2<double> coast = {tube.r.x + E * tube.w.x - t * tube.drift.x,
                                tube.r.y + E * tube.w.y - t * tube.drift.y};
    return farthest(tube, direction(coast, away));
  };
  if (tube.thrust_count > 0) {
    const std::size_t i = lowest(f);
    const Escape plan = with(tube, {a_x[i], a_y[i]});
    // At its own nearest time no other corner is better: it is the optimum.
    const Touch& nearest = plan.touches[0];
    const Vec2<double> a = best_at(nearest.time, nearest.shape.E);
    return a.x == plan.a.x && a.y == plan.a.y ? plan : best_corner(tube, plan);
  }
  const double t = least_of(f, lowest(f));
  const Escape plan = with(tube, best_at(t, E(t)));
  const Touch& nearest = plan.touches[0];
  constexpr double met = 1e-4;  // [m]
  const Vec2<double> a = best_at(nearest.time, nearest.shape.E);
  return touch(tube, a, nearest.time).gap <= plan.later() + met ? plan : climbed(tube, plan, away);
}

Escape EscapePlans::best_corner(const Tube& tube, Escape best) const noexcept {
  const Vec2<double> known = best.a;
  for (unsigned corner = 0; corner < 1U << tube.thrust_count; ++corner) {
    Vec2<double> a;
    for (int k = 0; k < tube.thrust_count; ++k) {
      const Vec2<double>& g = tube.thrusts[static_cast<std::size_t>(k)];
      const double side = (corner >> k & 1U) != 0 ? 1.0 : -1.0;
      a = {a.x + side * g.x, a.y + side * g.y};
    }
    if (a.x == known.x && a.y == known.y) continue;
    const Curve f = along(tube, a);
    if (f[lowest(f)] - tube.rho0 <= best.later())
      continue;  // between the times of the grid it is lower still
    const Escape plan = refined(tube, a, f);
    if (plan.later() > best.later()) best = plan;
  }
  return best;
}

Escape EscapePlans::climbed(const Tube& tube, Escape plan, const Vec2<double>& away) const noexcept {
  const auto along = [&](const Vec2<double>& m) { return with(tube, farthest(tube, direction(m, away))); };
  Escape other = along(away);
  for (Escape* start : {&plan, &other}) {
    for (int round = 0; round < 6; ++round) {
      const double t = start->touches[0].time, E_t = E(t);
      const Vec2<double> m = direction({tube.r.x + E_t * tube.w.x, tube.r.y + E_t * tube.w.y}, away);
      const Escape next = along(m),
                   half = along({tube.beta * m.x + start->a.x, tube.beta * m.y + start->a.y});
      const Escape& taken = next.later() > half.later() ? next : half;
      if (taken.later() <= start->later() + 1e-5) break;
      *start = taken;
    }
  }
  return other.later() > plan.later() ? other : plan;
}

}  // namespace sightline
