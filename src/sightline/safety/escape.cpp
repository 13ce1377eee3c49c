#include "sightline/safety/escape.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <type_traits>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr double tiny_length = 1e-9;

/// Number of lanes of S.
template <class S>
constexpr std::size_t lanes = 1;
template <int W>
constexpr std::size_t lanes<Lane<W>> = W;

double lane(double number, std::size_t) { return number; }
template <int W>
double lane(Lane<W> pack, std::size_t i) {
  return pack[static_cast<int>(i)];
}

/// v / |v|, or `other` if v is almost zero.
template <class S>
Vec2<S> direction(const Vec2<S>& v, const Vec2<S>& other) {
  const S length = sqrt(dot(v, v)), none = S(tiny_length) - length;
  return {where_negative(none, v.x / length, other.x), where_negative(none, v.y / length, other.y)};
}

/// Height that the plan has climbed at t [m].
template <class S>
S risen(const TubeOf<S>& tube, S t) {
  return clamp(tube.climb * t, -tube.room, tube.room);
}

/// The attainable acceleration that is greatest along a direction.
template <class S>
Vec2<S> farthest(const TubeOf<S>& tube, const Vec2<S>& along) {
  if (tube.thrust_count == 0) return {tube.beta * along.x, tube.beta * along.y};
  Vec2<S> a;
  for (int k = 0; k < tube.thrust_count; ++k) {
    const Vec2<S>& g = tube.thrusts[static_cast<std::size_t>(k)];
    const S side = where_negative(dot(g, along), S(-1.0), S(1.0));
    a = {a.x + side * g.x, a.y + side * g.y};
  }
  return a;
}

// The last bits of a value store its index in the curve, so that one minimum finds both. The
// relative error is 1e-14.
constexpr std::int64_t place_bits = 31;

double with_place(double f, std::int64_t place) {
  return std::bit_cast<double>((std::bit_cast<std::int64_t>(f) & ~place_bits) | place);
}
template <int W>
Lane<W> with_place(Lane<W> f, std::int64_t place) {
  using L = Lane<W>;
  return L((typename L::Vector)(((typename L::Bits)f.v & ~place_bits) | place));
}

/// Packs tubes of one robot, for one climb.
template <int W>
TubeOf<Lane<W>> side_by_side(EscapePlans::Tubes tubes, double climb, double room) {
  const Tube& first = *tubes.front();
  TubeOf<Lane<W>> all{.climb = climb, .room = room, .thrust_count = first.thrust_count};
  for (std::size_t k = 0; k < static_cast<std::size_t>(all.thrust_count); ++k)
    all.thrusts[k] = {first.thrusts[k].x, first.thrusts[k].y};
  for (int i = 0; i < W; ++i) {
    const Tube& tube = *tubes[std::min(static_cast<std::size_t>(i), tubes.size() - 1)];
    all.r.x.v[i] = tube.r.x, all.r.y.v[i] = tube.r.y, all.r.z.v[i] = tube.r.z;
    all.w.x.v[i] = tube.w.x, all.w.y.v[i] = tube.w.y;
    all.s.x.v[i] = tube.s.x, all.s.y.v[i] = tube.s.y;
    all.drift.x.v[i] = tube.drift.x, all.drift.y.v[i] = tube.drift.y, all.drift.z.v[i] = tube.drift.z;
    all.beta.v[i] = tube.beta;
    all.rho0.v[i] = tube.rho0;
    all.speed.v[i] = tube.speed;
    all.growth.v[i] = tube.growth;
    all.spread.v[i] = tube.spread;
    all.tie.x.v[i] = tube.tie.x, all.tie.y.v[i] = tube.tie.y;
  }
  return all;
}

}  // namespace

EscapePlans::EscapePlans(double drag, double dt, double lag)
    : c_(drag), per_c_(drag > 0 ? 1.0 / drag : 0.0), dt_(dt), e_back_(std::exp(drag * dt)), lag_(lag) {
  // Denser at the beginning, which decides most plans.
  for (std::size_t i = 0; i < times; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(times - 1);
    t_[i] = dt + (longest - dt) * part * std::sqrt(part);
    const EscapeShape at = shape(t_[i]);
    E_[i] = at.E, F_[i] = at.F, L_[i] = at.L;
    e_[i] = at.e, F_rate_[i] = at.F_rate, L_rate_[i] = at.L_rate;
  }
  ends_[0] = decay(0.0);
  for (std::size_t i = 1; i < times; ++i) ends_[i] = decay(0.5 * (t_[i - 1] + t_[i]));
  ends_[times] = decay(longest);
  between_ = static_cast<std::size_t>(parts(dt)) - 1;
  for (std::size_t i = 0; i < between_; ++i) {
    t_between_[i] = dt * static_cast<double>(i + 1) / static_cast<double>(between_ + 1);
    const EscapeShape at = shape(t_between_[i]);
    E_between_[i] = at.E, F_between_[i] = at.F, L_between_[i] = at.L;
  }
}

int EscapePlans::parts(double dt) noexcept {
  constexpr double rounded = 1e-9;
  return std::clamp(static_cast<int>(std::ceil(dt / longest_part - rounded)), 1, most_parts);
}

template <class S>
EscapeShapeOf<S> EscapePlans::without_lag(S t) const noexcept {
  const S ct = c_ * t, e = exp(-ct), E = (S(1.0) - e) * S(per_c_), F = (t - E) * S(per_c_);
  const S small = ct - S(1e-3);  // < 0: use the series
  const S drifted = where_negative(small, t * (S(1.0) - S(0.5) * ct), E);
  return {e, drifted, where_negative(small, S(0.5) * t * t * (S(1.0) - ct * S(1.0 / 3.0)), F), drifted};
}

// With k = 1 / tau and E_x = (1 - e^(-x t)) / x, L = (E_c - E_k) / (k - c) and L' = (e^(-c t) - e^(-k t)) / (k - c).
template <class S>
EscapeShapeOf<S> EscapePlans::shape_at(S t) const noexcept {
  EscapeShapeOf<S> at = without_lag(t);
  if (!lags()) return at;
  const double k = 1.0 / lag_, apart = k - c_;
  constexpr double alike = 1e-3;
  if (std::abs(apart) * longest < alike) {
    // The limit k -> c: minus the derivative of E_x by x, between the two.
    const S x(0.5 * (k + c_)), decayed = exp(-x * t);
    at.L = (S(1.0) - (S(1.0) + x * t) * decayed) / (x * x);
    at.L_rate = t * decayed;
  } else {
    const S kt = S(k) * t, decayed = exp(-kt);
    const S E_k = where_negative(kt - S(1e-3), t * (S(1.0) - S(0.5) * kt * (S(1.0) - kt * S(1.0 / 3.0))),
                                 (S(1.0) - decayed) * S(lag_));
    at.L = (at.E - E_k) * S(1.0 / apart);
    at.L_rate = (at.e - decayed) * S(1.0 / apart);
  }
  at.F = at.F - at.L;
  at.F_rate = at.E - at.L_rate;
  return at;
}

EscapePlans::Decay EscapePlans::decay(double t) const noexcept {
  return {t, std::exp(-c_ * t), lags() ? std::exp(-t / lag_) : 0.0};
}

double EscapePlans::E(double t) const noexcept { return without_lag(t).E; }
double EscapePlans::F(double t) const noexcept { return without_lag(t).F; }
EscapeShape EscapePlans::shape(double t) const noexcept { return shape_at(t); }
EscapeShape EscapePlans::shape_at_once(double t) const noexcept { return without_lag(t); }

EscapeShape EscapePlans::left(const Touch& touch) const noexcept {
  const double t = touch.time - dt_;
  if (lags() || c_ * t < 1e-3) return shape(t);
  const double e = touch.shape.e * e_back_, E = (1.0 - e) * per_c_;
  return {e, E, (t - E) * per_c_, E};
}

/// The plan search for one tube, or for several side by side.
template <class S>
struct EscapePlans::Search {
  using Curve = std::array<S, times>;
  using Places = std::array<std::size_t, lanes<S>>;

  /// q_a and f_a at one time t, with derivatives.
  struct Point {
    S t;
    Vec3<S> q, n;
    EscapeShapeOf<S> shape;
    S f, slope, curvature;
  };
  struct Plan {
    S now;  // least f before the next sample
    Vec2<S> a;
    Point first, second;  // global minimum of f; another minimum
    S is_alone;           // < 0: another minimum exists
  };
  struct Found {
    Plan plan;
    S uncertain;  // < 0: another plan may be better
  };

  Search(const EscapePlans& escape_plans, const TubeOf<S>& of) : plans(escape_plans), tube(of) {
    const S half = S(0.5) * tube.growth;
    for (std::size_t k = 0; k < times; ++k) {
      const S t(plans.t_[k]), E(plans.E_[k]);
      const S z = tube.r.z + risen(tube, t) - t * tube.drift.z;
      x[k] = tube.r.x + E * tube.w.x - t * tube.drift.x;
      y[k] = tube.r.y + E * tube.w.y - t * tube.drift.y;
      add_late(S(plans.L_[k]), x[k], y[k]);
      height_squared[k] = z * z;
      reach[k] = t * (tube.speed + half * t) + tube.spread * E;
    }
  }

  Point at(const Vec2<S>& a, S t) const {
    Point p;
    p.t = t;
    p.shape = plans.shape_at(t);
    const S e = p.shape.e, E = p.shape.E, F = p.shape.F;
    const S climb = where_negative(absolute(tube.climb) * t - tube.room, tube.climb, S(0.0));
    p.q = {tube.r.x + E * tube.w.x + F * a.x - t * tube.drift.x,
           tube.r.y + E * tube.w.y + F * a.y - t * tube.drift.y,
           tube.r.z + risen(tube, t) - t * tube.drift.z};
    const S pushed = p.shape.F_rate;
    Vec3<S> rate = {e * tube.w.x + pushed * a.x - tube.drift.x, e * tube.w.y + pushed * a.y - tube.drift.y,
                    climb - tube.drift.z};
    const S c(plans.c_);
    Vec2<S> bend = {e * (a.x - c * tube.w.x), e * (a.y - c * tube.w.y)};
    if (plans.lags()) {
      const auto& [x_s, y_s] = tube.s;
      p.q.x += p.shape.L * x_s, p.q.y += p.shape.L * y_s;
      rate.x += p.shape.L_rate * x_s, rate.y += p.shape.L_rate * y_s;
      const S left = exp(-t * S(1.0 / plans.lag_));
      bend = {a.x + left * (x_s - a.x) - c * (rate.x + tube.drift.x),
              a.y + left * (y_s - a.y) - c * (rate.y + tube.drift.y)};
    }
    const S length = norm(p.q), apart = S(tiny_length) - length;
    const S inverse = where_negative(apart, S(1.0) / length, S(0.0)), along = dot(p.q, rate) * inverse;
    p.n = inverse * p.q;
    if (const S touching = where_negative(apart, S(1.0), S(-1.0)); any_negative(touching)) {
      const Vec2<S> level = direction(a, tube.tie);
      p.n = {where_negative(touching, level.x, p.n.x), where_negative(touching, level.y, p.n.y),
             where_negative(touching, S(0.0), p.n.z)};
    }
    p.f = length - tube.rho0 - t * (tube.speed + S(0.5) * tube.growth * t) - tube.spread * E;
    p.slope = along - tube.speed - tube.growth * t - tube.spread * e;
    p.curvature = (p.q.x * bend.x + p.q.y * bend.y + dot(rate, rate) - along * along) * inverse -
                  tube.growth + c * tube.spread * e;
    return p;
  }

  /// f + rho0 on the time grid.
  Curve along(const Curve& a_x, const Curve& a_y) const {
    Curve f;
    for (std::size_t k = 0; k < times; ++k) {
      const S q_x = x[k] + S(plans.F_[k]) * a_x[k], q_y = y[k] + S(plans.F_[k]) * a_y[k];
      f[k] = sqrt(q_x * q_x + q_y * q_y + height_squared[k]) - reach[k];
    }
    return f;
  }
  Curve along(const Vec2<S>& a) const {
    Curve a_x, a_y;
    a_x.fill(a.x);
    a_y.fill(a.y);
    return along(a_x, a_y);
  }

  static Places lowest(const Curve& f) {
    constexpr std::size_t third = times / 3;
    static_assert(times <= place_bits && third == 8);
    Curve g;
    for (std::size_t k = 0; k < times; ++k) g[k] = with_place(f[k], static_cast<std::int64_t>(k));
    for (std::size_t k = 0; k < third; ++k) g[k] = minimum(minimum(g[k], g[k + third]), g[k + 2 * third]);
    for (std::size_t half = third / 2; half > 0; half /= 2) {
      for (std::size_t k = 0; k < half; ++k) g[k] = minimum(g[k], g[k + half]);
    }
    Places place;
    for (std::size_t i = 0; i < place.size(); ++i)
      place[i] = static_cast<std::size_t>(std::bit_cast<std::int64_t>(lane(g[0], i)) & place_bits);
    return place;
  }

  static S value(const Curve& f, const Places& i) {
    if constexpr (lanes<S> == 1) {
      return f[i[0]];
    } else {
      S values;
      for (std::size_t l = 0; l < lanes<S>; ++l) values.v[l] = f[i[l]].v[l];
      return values;
    }
  }
  S time(const Places& i) const {
    if constexpr (lanes<S> == 1) {
      return plans.t_[i[0]];
    } else {
      return S::gather(plans.t_.data(), i);
    }
  }

  /// Time of the minimum of f near grid points.
  S least_of(const Curve& f, const Places& i) const {
    // Vertex of the parabola through three points.
    Places inner, before, after;
    for (std::size_t l = 0; l < i.size(); ++l) {
      inner[l] = std::clamp<std::size_t>(i[l], 1, times - 2);
      before[l] = inner[l] - 1;
      after[l] = inner[l] + 1;
    }
    const S t = time(inner), middle = value(f, inner);
    const S a = t - time(before), b = time(after) - t, fa = value(f, before) - middle,
            fb = value(f, after) - middle;
    const S up = fa * b * b - fb * a * a, down = S(2.0) * (fa * b + fb * a);
    const S vertex = t + where_negative(-down, clamp(up / down, -a, b), S(0.0));
    // An end of the grid is not interpolated.
    const S at_i = time(i);
    return where_negative(-absolute(at_i - t), at_i, vertex);
  }

  /// Adds L s, by which the present acceleration moves the robot.
  void add_late(S L, S& p_x, S& p_y) const {
    if (plans.lags()) p_x += L * tube.s.x, p_y += L * tube.s.y;
  }

  /// The minimum of f near grid points, by golden sections of the interval: the curvature of f may
  /// change its sign in it.
  Point nearest_by_sections(const Vec2<S>& a, const Curve& f, const Places& i) const {
    constexpr int rounds = 11;
    Places before = i, after = i;
    for (std::size_t l = 0; l < i.size(); ++l) {
      before[l] = i[l] > 0 ? i[l] - 1 : i[l];
      after[l] = std::min(i[l] + 1, times - 1);
    }
    S low = time(before), high = time(after);
    const S golden(std::numbers::phi - 1.0);
    S left = high - golden * (high - low), right = low + golden * (high - low);
    S at_left = at(a, left).f, at_right = at(a, right).f;
    for (int round = 0; round < rounds; ++round) {
      const S rises = at_left - at_right;  // < 0: the minimum is before `right`
      low = where_negative(rises, low, left);
      high = where_negative(rises, right, high);
      const S step = golden * (high - low), kept = where_negative(rises, left, right),
              tried = where_negative(rises, high - step, low + step), at_tried = at(a, tried).f,
              at_kept = where_negative(rises, at_left, at_right);
      left = where_negative(rises, tried, kept), right = where_negative(rises, kept, tried);
      at_left = where_negative(rises, at_tried, at_kept), at_right = where_negative(rises, at_kept, at_tried);
    }
    const S t = S(0.5) * (low + high);
    const Point p = at(a, t);
    const S astray = value(f, i) - tube.rho0 - p.f;
    return any_negative(astray) ? at(a, where_negative(astray, time(i), t)) : p;
  }

  /// The minimum of f near grid points, by Newton steps.
  Point nearest(const Vec2<S>& a, const Curve& f, const Places& i) const {
    if (plans.lags()) return nearest_by_sections(a, f, i);
    S t = least_of(f, i);
    Point p = at(a, t);
    constexpr double near = 1e-4;  // [s]
    S stays(-1.0);                 // < 0: not converged
    for (int round = 0; round < 3; ++round) {
      const S next = clamp(t - clamp(p.slope / p.curvature, -0.25, 0.25), plans.dt_, longest);
      const S step = absolute(next - t);
      stays = where_negative(step - S(near), S(1.0), where_negative(-p.curvature, stays, S(1.0)));
      if (!any_negative(stays)) break;
      t = where_negative(stays, next, t);
      p = at(a, t);
      stays = where_negative(step - S(0.03), S(1.0), stays);  // the next step: a thousandth of it
    }
    // If the refinement diverged, the minimum of the grid is used.
    const S astray = value(f, i) - tube.rho0 - p.f;
    return any_negative(astray) ? at(a, where_negative(astray, time(i), t)) : p;
  }

  /// The least f before the next sample.
  S before_next(const Vec2<S>& a) const {
    S least = norm(tube.r);
    for (std::size_t k = 0; k < plans.between_; ++k) {
      const S t(plans.t_between_[k]), E(plans.E_between_[k]), F(plans.F_between_[k]);
      Vec3<S> q = {tube.r.x + E * tube.w.x + F * a.x - t * tube.drift.x,
                   tube.r.y + E * tube.w.y + F * a.y - t * tube.drift.y,
                   tube.r.z + risen(tube, t) - t * tube.drift.z};
      add_late(S(plans.L_between_[k]), q.x, q.y);
      least = minimum(least, norm(q) - t * (tube.speed + S(0.5) * tube.growth * t) - tube.spread * E);
    }
    return least - tube.rho0;
  }

  Plan refined(const Vec2<S>& a, const Curve& f) const {
    const Places i = lowest(f);
    Plan plan;
    plan.now = before_next(a);
    plan.a = a;
    plan.first = nearest(a, f, i);
    // Another minimum, nearly as low: the command could make it the lower one.
    constexpr double none = 1e300, nearly = 0.1;  // [m]
    Curve least;
    for (std::size_t k = 1; k + 1 < times; ++k)
      least[k] = where_negative(f[k] - f[k + 1], where_negative(f[k - 1] - f[k], S(none), f[k]), S(none));
    least[0] = where_negative(f[0] - f[1], f[0], S(none));
    least[times - 1] = S(none);
    for (std::size_t l = 0; l < i.size(); ++l) {
      if constexpr (lanes<S> == 1)
        least[i[l]] = none;
      else
        least[i[l]].v[l] = none;
    }
    const Places other = lowest(least);
    plan.is_alone = value(least, other) - (plan.first.f + tube.rho0 + S(nearly));
    if (any_negative(plan.is_alone)) plan.second = nearest(a, f, other);
    return plan;
  }

  /// The best plan for the time at which the upper bound is least.
  Found best() const {
    Curve a_x{}, a_y{};
    S turns(1.0);  // < 0: another corner is best at another time
    for (std::size_t j = 0; j < static_cast<std::size_t>(tube.thrust_count); ++j) {
      const Vec2<S>& g = tube.thrusts[j];
      S sides(0.0);
      for (std::size_t k = 0; k < times; ++k) {
        const S side = where_negative(g.x * x[k] + g.y * y[k], S(-1.0), S(1.0));
        a_x[k] += side * g.x;
        a_y[k] += side * g.y;
        sides += side;
      }
      turns = minimum(turns, absolute(sides) - S(static_cast<double>(times) - 0.5));
    }
    if (tube.thrust_count == 0) {
      turns = S(-1.0);
      for (std::size_t k = 0; k < times; ++k) {
        const S out = tube.beta / sqrt(x[k] * x[k] + y[k] * y[k] + S(tiny_length * tiny_length));
        a_x[k] = out * x[k];
        a_y[k] = out * y[k];
      }
    }
    Curve f = along(a_x, a_y);
    if (!any_negative(turns)) {
      const Plan plan = refined({a_x[0], a_y[0]}, f);
      return {plan, minimum(turns, dips(plan))};
    }

    const Places i = lowest(f);
    Vec2<S> a = {value(a_x, i), value(a_y, i)};
    if (tube.thrust_count == 0) {
      const S t = least_of(f, i);
      a = best_at(t, plans.shape_at(t));
    }
    f = along(a);
    const Plan plan = refined(a, f);
    // If no plan is better at the plan's own tightest time, the plan is optimal.
    const Point& nearest = plan.first;
    const Vec2<S> there = best_at(nearest.t, nearest.shape);
    // With a lag, a robot at the edge of its safe set regains no error.
    constexpr double met = 1e-4, closely = 1e-6, edge = 0.05;  // [m]
    const S off = plans.lags() ? where_negative(plan.first.f - S(edge), S(closely), S(met)) : S(met);
    const S better = tube.thrust_count == 0 ? plan.first.f + off - at(there, nearest.t).f
                                            : -absolute(there.x - a.x) - absolute(there.y - a.y);
    return {plan, minimum(where_negative(turns, better, S(1.0)), dips(plan))};
  }
  /// < 0: the plan has its minimum within the period, which the search has not covered.
  S dips(const Plan& plan) const {
    if (plans.between_ == 0) return S(1.0);
    const S later = plan.now - plan.first.f, dip = plan.now - (norm(tube.r) - tube.rho0);
    return where_negative(later, where_negative(dip, S(-1.0), S(1.0)), S(1.0));
  }
  Vec2<S> away() const { return direction<S>({tube.r.x, tube.r.y}, direction(tube.w, tube.tie)); }
  Vec2<S> best_at(S t, const EscapeShapeOf<S>& at) const {
    Vec2<S> coast = {tube.r.x + at.E * tube.w.x - t * tube.drift.x,
                     tube.r.y + at.E * tube.w.y - t * tube.drift.y};
    add_late(at.L, coast.x, coast.y);
    return farthest(tube, direction(coast, away()));
  }

  static Vec2<S> same(const Vec2<double>& a) { return {S(a.x), S(a.y)}; }
  /// Whether f is at least `wanted` now and at all times of the grid.
  bool is_at_least(double wanted, const Curve& f) const {
    S least = norm(tube.r);
    for (const S& value : f) least = minimum(least, value);
    return !any_negative(least - tube.rho0 - S(wanted));
  }

  void write(const Point& p, std::size_t l, Touch& to) const {
    const double t = lane(p.t, l), climb = lane(tube.climb, l);
    to.gap = lane(p.f, l);
    to.time = t;
    to.n.x = lane(p.n.x, l), to.n.y = lane(p.n.y, l), to.n.z = lane(p.n.z, l);
    to.shape = {lane(p.shape.e, l),      lane(p.shape.E, l), lane(p.shape.F, l),
                lane(p.shape.F_rate, l), lane(p.shape.L, l), lane(p.shape.L_rate, l)};
    to.level = climb != 0 && std::abs(climb) * t >= lane(tube.room, l);
    to.slope = lane(p.slope, l);
    to.curvature = lane(p.curvature, l);
  }
  void write(const Plan& plan, std::size_t l, Escape& to) const {
    to.now = lane(plan.now, l);
    to.a.x = lane(plan.a.x, l), to.a.y = lane(plan.a.y, l);
    to.count = lane(plan.is_alone, l) < 0 ? 2 : 1;
    write(plan.first, l, to.touches[0]);
    if (to.count == 2) write(plan.second, l, to.touches[1]);
  }
  Escape escape(const Plan& plan) const {
    Escape escape;
    write(plan, 0, escape);
    return escape;
  }

  const EscapePlans& plans;
  const TubeOf<S>& tube;
  Curve x, y, height_squared, reach;  // of q_0; growth of rho
};

Touch EscapePlans::touch(const Tube& tube, const Vec2<double>& a, double t) const noexcept {
  const Search<double> search(*this, tube);
  Touch touch;
  search.write(search.at(a, t), 0, touch);
  return touch;
}

Escape EscapePlans::with(const Tube& tube, const Vec2<double>& a) const noexcept {
  const Tube* const one = &tube;
  Escape plan;
  with({&one, 1}, {a, tube.climb, tube.room}, -infinity, {&plan, 1});
  return plan;
}

bool EscapePlans::keeps(const Tube& tube, const Vec2<double>& a, double wanted) const noexcept {
  if (tube.climb != 0 || tube.growth != 0) return false;
  // q_a'' = A e^(-c t) + B e^(-t / tau).
  const double share = lags() ? 1.0 / (1.0 - c_ * lag_) : 0.0;
  const Vec2<double> B = {share * (tube.s.x - a.x), share * (tube.s.y - a.y)},
                     A = {a.x - c_ * (tube.w.x + lag_ * B.x), a.y - c_ * (tube.w.y + lag_ * B.y)};
  struct Tangent {
    double t, f, slope;
    double A, B;  // of the second derivative, along n
  };
  const auto tangent = [&](double t, double f, double slope, double n_x, double n_y) {
    return Tangent{t, f, slope, n_x * A.x + n_y * A.y + c_ * tube.spread, n_x * B.x + n_y * B.y};
  };
  const auto is_kept = [&](const Tangent& at, const Decay& from, const Decay& to) {
    const double bend = std::min(at.A * from.e, at.A * to.e) + std::min(at.B * from.late, at.B * to.late);
    const double before = from.t - at.t, after = to.t - at.t, spare = at.f - wanted,
                 straight = spare + std::min(before * at.slope, after * at.slope);
    if (bend <= 0) return straight + 0.5 * bend * square(std::max(-before, after)) >= 0;
    // A parabola is not below its tangent, nor below its vertex.
    return straight >= 0 || 2 * bend * spare >= square(at.slope);
  };
  const Search<double> search(*this, tube);
  constexpr int most_halvings = 64;
  constexpr std::size_t deepest = 16;
  std::array<std::pair<Decay, Decay>, deepest + 1> open;
  int halvings = 0;
  for (std::size_t k = 0; k < times; ++k) {
    const Vec2<double> q = {search.x[k] + F_[k] * a.x, search.y[k] + F_[k] * a.y};
    const double length = std::sqrt(dot(q, q) + search.height_squared[k]), inverse = 1.0 / length,
                 z = tube.r.z - t_[k] * tube.drift.z, f = length - search.reach[k] - tube.rho0;
    if (!(f >= wanted)) return false;
    const double along = q.x * (e_[k] * tube.w.x + F_rate_[k] * a.x + L_rate_[k] * tube.s.x - tube.drift.x) +
                         q.y * (e_[k] * tube.w.y + F_rate_[k] * a.y + L_rate_[k] * tube.s.y - tube.drift.y) -
                         z * tube.drift.z;
    const Tangent at =
        tangent(t_[k], f, along * inverse - tube.speed - e_[k] * tube.spread, q.x * inverse, q.y * inverse);
    if (k + 1 == times) {
      // After the last time the slope falls by less than these.
      const Decay& end = ends_[times];
      const double lost = (at.A < 0 ? -at.A * end.e / c_ : 0.0) + (at.B < 0 ? -at.B * end.late * lag_ : 0.0);
      if (!(at.slope >= lost)) return false;
    }
    if (is_kept(at, ends_[k], ends_[k + 1])) continue;
    std::size_t count = 0;
    open[count++] = {ends_[k], ends_[k + 1]};
    while (count > 0) {
      if (count == open.size() || ++halvings > most_halvings) return false;
      const auto [from, to] = open[--count];
      const Decay middle = decay(0.5 * (from.t + to.t));
      const auto p = search.at(a, middle.t);
      if (!(p.f >= wanted)) return false;
      if (is_kept(tangent(middle.t, p.f, p.slope, p.n.x, p.n.y), from, to)) continue;
      open[count++] = {from, middle};
      open[count++] = {middle, to};
    }
  }
  return true;
}

Escape EscapePlans::best(const Tube& tube) const noexcept {
  const Tube* const one = &tube;
  Escape plan;
  Escape* const to = &plan;
  best({&one, 1}, {&to, 1});
  return plan;
}

template <class Visit>
void EscapePlans::in_packs(Tubes tubes, double climb, double room, Visit visit) const noexcept {
  const auto pack = [&]<int W>(std::size_t first, std::size_t count, std::integral_constant<int, W>) {
    const auto all = side_by_side<W>(tubes.subspan(first, count), climb, room);
    return visit(Search<Lane<W>>(*this, all), first, count);
  };
  constexpr std::size_t narrow = narrow_width, wide = native_width;
  for (std::size_t i = 0, count; i < tubes.size(); i += count) {
    count = std::min(tubes.size() - i, wide);
    bool goes_on;
    if (count == 1) {
      Tube one = *tubes[i];
      one.climb = climb, one.room = room;
      goes_on = visit(Search<double>(*this, one), i, count);
    } else if (count <= narrow) {
      goes_on = pack(i, count, std::integral_constant<int, narrow_width>());
    } else {
      goes_on = pack(i, count, std::integral_constant<int, native_width>());
    }
    if (!goes_on) return;
  }
}

void EscapePlans::best(Tubes tubes, std::span<Escape* const> plans) const noexcept {
  in_packs(tubes, 0.0, 0.0, [&](const auto& search, std::size_t first, std::size_t count) {
    const auto found = search.best();
    for (std::size_t l = 0; l < count; ++l) {
      Escape& plan = *plans[first + l];
      search.write(found.plan, l, plan);
      if (lane(found.uncertain, l) < 0) plan = best_of_all(Search<double>(*this, *tubes[first + l]), plan);
    }
    return true;
  });
}

bool EscapePlans::with(Tubes tubes, const EscapeFlight& flight, double wanted,
                       std::span<Escape> plans) const noexcept {
  bool all = true;
  in_packs(tubes, flight.climb, flight.room, [&](const auto& search, std::size_t first, std::size_t count) {
    const auto a = search.same(flight.a);
    const auto f = search.along(a);
    if (!search.is_at_least(wanted, f)) return all = false;
    const auto plan = search.refined(a, f);
    for (std::size_t l = 0; l < count; ++l) search.write(plan, l, plans[first + l]);
    return true;
  });
  return all;
}

Escape EscapePlans::best_of_all(const Search<double>& search, const Escape& plan) const noexcept {
  const Tube& tube = search.tube;
  // Compares within the period, too; for equal reserves, the later minimum decides.
  const bool dips = between_ > 0;
  const auto better = [&](const Escape& one, const Escape& other) {
    const double more = dips ? one.reserve() - other.reserve() : 0.0;
    return more == 0 ? one.later() > other.later() : more > 0;
  };
  if (tube.thrust_count > 0) {
    Escape best = plan;
    for (unsigned corner = 0; corner < 1U << tube.thrust_count; ++corner) {
      Vec2<double> a;
      for (int k = 0; k < tube.thrust_count; ++k) {
        const Vec2<double>& g = tube.thrusts[static_cast<std::size_t>(k)];
        const double side = (corner >> k & 1U) != 0 ? 1.0 : -1.0;
        a = {a.x + side * g.x, a.y + side * g.y};
      }
      if (a.x == plan.a.x && a.y == plan.a.y) continue;
      const auto f = search.along(a);
      if (search.value(f, search.lowest(f)) - tube.rho0 <= (dips ? best.reserve() : best.later()))
        continue;  // the minimum between grid points is lower still
      const Escape other = search.escape(search.refined(a, f));
      if (better(other, best)) best = other;
    }
    return best;
  }
  // Gradient ascent in the disc, from the plan and from the direction straight away.
  const Vec2<double> away = search.away();
  const auto along = [&](const Vec2<double>& m) {
    const Vec2<double> a = farthest(tube, direction(m, away));
    return search.escape(search.refined(a, search.along(a)));
  };
  const auto best_direction = [&](double t) {
    const EscapeShape at = shape(t);
    Vec2<double> coast = {tube.r.x + at.E * tube.w.x, tube.r.y + at.E * tube.w.y};
    search.add_late(at.L, coast.x, coast.y);
    return direction<double>(coast, away);
  };
  const std::size_t starts = dips ? 3 : 2;
  std::array<Escape, 3> from = {plan, along(away)};
  if (dips) from[2] = along(best_direction(0.5 * dt_));
  for (Escape* start = from.data(); start != from.data() + starts; ++start) {
    for (int round = 0; round < 6; ++round) {
      const Vec2<double> m = best_direction(start->touches[0].time);
      const Escape next = along(m),
                   half = along({tube.beta * m.x + start->a.x, tube.beta * m.y + start->a.y});
      const Escape& taken = better(next, half) ? next : half;
      constexpr double gained = 1e-5;  // [m]
      if (taken.later() <= start->later() + gained && !(dips && taken.reserve() > start->reserve() + gained))
        break;
      if (better(*start, taken)) break;
      *start = taken;
    }
  }
  const Escape& first = better(from[1], from[0]) ? from[1] : from[0];
  const Escape& found = dips && better(from[2], first) ? from[2] : first;
  return lags() ? best_around(search, found) : found;
}

Escape EscapePlans::best_around(const Search<double>& search, const Escape& found) const noexcept {
  constexpr int directions = 32, rounds = 24;
  constexpr double step = 2 * std::numbers::pi / directions;
  const double from = std::atan2(found.a.y, found.a.x);
  const auto at = [&](double turned) {
    const SinCos<double> to = sincos(from + turned);
    const Vec2<double> a = {search.tube.beta * to.cos, search.tube.beta * to.sin};
    return search.escape(search.refined(a, search.along(a)));
  };
  const auto value = [&](const Escape& one) { return between_ > 0 ? one.reserve() : one.later(); };
  Escape best = found;
  double angle = 0.0;
  const auto consider = [&](double turned) {
    const Escape one = at(turned);
    if (value(one) > value(best)) best = one, angle = turned;
    return value(one);
  };
  for (int k = 1; k < directions; ++k) consider(k * step);
  double low = angle - step, high = angle + step;
  for (int round = 0; round < rounds; ++round) {
    const double third = (high - low) / 3;
    if (consider(low + third) < consider(high - third))
      low += third;
    else
      high -= third;
  }
  return best;
}

}  // namespace sightline
