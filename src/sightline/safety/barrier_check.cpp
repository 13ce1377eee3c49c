// Nonlinear check of a command against its rows, and the replacement of a command that fails.
#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/safety/barrier_threats.hpp"

namespace sightline {
namespace {

/// Evaluates f at times from dt on, denser at the beginning and around the minimum. @return the
/// least value
template <class F>
double least_over(double dt, const F& f) {
  constexpr std::size_t times = 25, rounds = 10;
  constexpr double longest = 8.0;  // [s]
  const auto time = [&](double i) {
    const double part = i / static_cast<double>(times - 1);
    return dt + (longest - dt) * part * std::sqrt(part);
  };
  double least = infinity, at = 0.0;
  for (std::size_t i = 0; i < times; ++i) {
    const double value = f(time(static_cast<double>(i)));
    if (value < least) least = value, at = static_cast<double>(i);
  }
  double from = std::max(0.0, at - 1), to = std::min(static_cast<double>(times - 1), at + 1);
  for (std::size_t round = 0; round < rounds; ++round) {
    const double third = (to - from) / 3, low = f(time(from + third)), high = f(time(to - third));
    least = std::min({least, low, high});
    if (low < high)
      to -= third;
    else
      from += third;
  }
  return least;
}

}  // namespace

/// Required reserve of a plan after the period [m]. A tolerance lets the reserve fall by half of
/// the margin.
double Barrier::required(const Threat& threat) const noexcept {
  constexpr double drift = 5e-4;  // [m]
  const double used = options_.rate * dt_;
  return threat.margin + (1.0 - used) * threat.reserve - used * (0.5 * threat.margin + drift);
}

Barrier::Flown Barrier::flown(std::span<const double> x, std::span<const double> u) const noexcept {
  Flown flown;
  std::array<double, most_states> state;
  std::copy(x.begin(), x.end(), state.begin());
  for (int k = 1; k < parts_; ++k) {
    model_.step(state.data(), u.data(), dt_ / parts_);
    flown.between.push_back(model_.sight(state.data(), u.data()).p);
  }
  flown.after = next(x, u);
  return flown;
}

/// Reserve beyond the requirement against all neighbours [m]; >= 0: the command is accepted.
double Barrier::left_by(const Sight<double>& self, const Rows& rows, const Flown& flown) const noexcept {
  double least = left_of_chases(self, rows, flown);
  for (const Threat& threat : rows.threats) {
    if (threat.behavior == Behavior::cooperative) least = std::min(least, left_of_pair(self, threat, flown));
  }
  return least;
}

/// The same against uncooperative neighbours: for the motion within the period, and for the rest of
/// the plan.
double Barrier::left_of_chases(const Sight<double>& self, const Rows& rows,
                               const Flown& flown) const noexcept {
  const Next& after = flown.after;
  const EscapeShape step = plans_.shape(dt_);
  double least = infinity;
  Bounded<Tube, most_neighbours> rest;
  Bounded<const Threat*, most_neighbours> of;
  for (const Threat& threat : rows.threats) {
    if (threat.behavior == Behavior::cooperative || threat.reserve >= ample_) continue;
    const Tube& tube = threat.tube;
    const double wanted = required(threat);
    for (std::size_t k = 0; k < flown.between.size(); ++k) {
      const double s = dt_ * static_cast<double>(k + 1) / parts_;
      const Vec3<double> q = tube.r + (flown.between[k] - self.p) - s * tube.drift;
      const double rho =
          tube.rho0 - rows.beside + s * (tube.speed + 0.5 * tube.growth * s) + tube.spread * plans_.E(s);
      least = std::min(least, norm(q) - rho - wanted);
    }
    Tube& later = rest.push_back(tube);
    later.r = tube.r + (after.p - self.p) - dt_ * tube.drift;
    later.w = after.v;
    later.rho0 += dt_ * (tube.speed + 0.5 * tube.growth * dt_) + tube.spread * step.E +
                  std::abs(after.beside) - rows.beside;
    later.speed += dt_ * tube.growth;
    later.spread *= step.e;
    later.room = std::max(0.0, tube.room - std::copysign(1.0, tube.climb) * (after.p.z - self.p.z));
    of.push_back(&threat);
  }
  // Neighbours with the same plan are evaluated side by side.
  std::array<Escape, most_neighbours> plans;
  for (std::size_t first = 0; first < of.size() && least >= 0;) {
    const Threat& leading = *of[first];
    Bounded<const Tube*, most_neighbours> tubes;
    std::size_t end = first;
    for (; end < of.size(); ++end) {
      const Vec2<double>& a = of[end]->plan.a;
      if (a.x != leading.plan.a.x || a.y != leading.plan.a.y || of[end]->tube.climb != leading.tube.climb)
        break;
      tubes.push_back(&rest[end]);
    }
    const Vec2<double> a =
        can_.turns ? rotate(after.d, rotate<double>({self.d.x, -self.d.y}, leading.plan.a)) : leading.plan.a;
    plans_.with(tubes.items(), {a, leading.tube.climb, rest[first].room}, -infinity, plans);
    for (std::size_t k = first; k < end; ++k)
      least = std::min(least, plans[k - first].reserve() - required(*of[k]));
    first = end;
  }
  return least;
}

/// The same against a cooperative neighbour: at any time this robot may use its share of the spare
/// reserve.
double Barrier::left_of_pair(const Sight<double>& self, const Threat& threat,
                             const Flown& flown) const noexcept {
  const Tube& tube = threat.tube;
  const Vec2<double> own = {0.5 * threat.plan.a.x, 0.5 * threat.plan.a.y};
  const auto beside_plan = [&](const Vec3<double>& p, const EscapeShape& at) {
    return Vec3<double>{p.x - self.p.x - at.E * self.v.x - at.F * own.x,
                        p.y - self.p.y - at.E * self.v.y - at.F * own.y, p.z - self.p.z};
  };
  const double wanted = required(threat);
  const auto left = [&](const EscapeShape& at, const Vec3<double>& moved) {
    const Vec3<double> q = {tube.r.x + at.E * tube.w.x + at.F * threat.plan.a.x,
                            tube.r.y + at.E * tube.w.y + at.F * threat.plan.a.y, tube.r.z};
    const double length = norm(q), gap = length - tube.rho0 - tube.spread * at.E;
    return dot(q, moved) / std::max(length, 1e-9) + options_.share * (gap - wanted);
  };
  double least = infinity;
  for (std::size_t k = 0; k < flown.between.size(); ++k) {
    const EscapeShape at = plans_.shape(dt_ * static_cast<double>(k + 1) / parts_);
    least = std::min(least, left(at, beside_plan(flown.between[k], at)));
  }
  const EscapeShape step = plans_.shape(dt_);
  const Vec3<double> p = beside_plan(flown.after.p, step);
  const Vec2<double> v = {flown.after.v.x - step.e * self.v.x - step.E * own.x,
                          flown.after.v.y - step.e * self.v.y - step.E * own.y};
  return std::min(least, least_over(dt_, [&](double t) {
                    const double E = plans_.E(t - dt_);
                    return left(plans_.shape(t), {p.x + E * v.x, p.y + E * v.y, p.z});
                  }));
}

/// Distance to a bound of the world after braking [m]; n: inward normal.
double Barrier::braked(const Vec2<double>& n, const Vec3<double>& p, const Vec2<double>& v,
                       double part) const noexcept {
  const double away = std::min(dot(n, v), 0.0), stop = stopping_time(away, part);
  return options_.world + n.x * p.x + n.y * p.y + plans_.E(stop) * away + part * b_ * plans_.F(stop);
}

/// Distance to the bounds of the world beyond the requirement [m], after braking and within the
/// period. A bound that is already exceeded must not be exceeded further.
double Barrier::left_of_walls(const Sight<double>& self, double part, const Flown& flown) const noexcept {
  constexpr double touched = 1e-6;  // [m]
  double least = infinity;
  for (const Vec2<double>& n : inward) {
    const double now = braked(n, self.p, {self.v.x, self.v.y}, part);
    const double wanted = now > 0 ? (1.0 - options_.rate * dt_) * now : now;
    least = std::min(least, braked(n, flown.after.p, flown.after.v, part) - wanted);
    for (const Vec3<double>& p : flown.between)
      least = std::min(least, options_.world + n.x * p.x + n.y * p.y - std::min(now, 0.0));
  }
  return least + touched;
}

/// If u leaves less than 0, replaces u by the nearest command on the line to the plan's own command
/// that leaves at least 0.
/// @param a, rise  the plan's acceleration [m/s^2], and its climb within the period [m]
/// @param left  reserve of a command beyond the requirement [m]
/// @return the remaining reserve [m]; if less than 0, no command suffices, and u is the better of
///         the two
template <class Left>
double Barrier::towards_plan(std::span<const double> x, const Sight<double>& self, const Vec2<double>& a,
                             double rise, std::span<const double> u_min, std::span<const double> u_max,
                             std::span<double> u, const Left& left) const noexcept {
  const double leaves_now = left(u);
  if (leaves_now >= 0) return leaves_now;
  std::array<double, most_inputs> command{}, tried{};
  const auto planned = std::span(command).first(u.size());
  for (std::size_t k = 0; k < u.size(); ++k) planned[k] = std::clamp(0.0, u_min[k], u_max[k]);
  const EscapeShape step = plans_.shape(dt_);
  reach_for(x, {step.e * self.v.x + step.E * a.x, step.e * self.v.y + step.E * a.y, self.p.z + rise}, u_min,
            u_max, planned);
  double leaves = left(planned);
  if (leaves <= leaves_now) return leaves_now;
  const auto between = [&](double part, std::size_t k) {
    return std::clamp(planned[k] + part * (u[k] - planned[k]), u_min[k], u_max[k]);
  };
  constexpr int halvings = 4;
  double share = 0.0, more = 0.5;
  for (int round = 0; round < halvings && leaves >= 0; ++round, more *= 0.5) {
    for (std::size_t k = 0; k < u.size(); ++k) tried[k] = between(share + more, k);
    const double then = left(std::span<const double>(tried).first(u.size()));
    if (then >= 0) share += more, leaves = then;
  }
  for (std::size_t k = 0; k < u.size(); ++k) u[k] = between(share, k);
  return leaves;
}

/// Makes u keep the bounds of the world if braking does. @param after  state under u
void Barrier::ensure_walls(std::span<const double> x, const Sight<double>& self, const Rows& rows,
                           std::span<const double> u_min, std::span<const double> u_max, std::span<double> u,
                           Next& after) const noexcept {
  if (options_.world == infinity) return;
  const auto nearer = [&](const Vec2<double>& n, const Vec2<double>& m) {
    const Vec2<double> v = {self.v.x, self.v.y};
    return braked(n, self.p, v, rows.part) < braked(m, self.p, v, rows.part);
  };
  const auto left = [&](std::span<const double> one) {
    return left_of_walls(self, rows.part, flown(x, one));
  };
  auto away = inward;
  std::partial_sort(away.begin(), away.begin() + 2, away.end(), nearer);
  const double b = rows.part * b_, of_both = std::sqrt(0.5) * b;
  if (towards_plan(x, self, {b * away[0].x, b * away[0].y}, 0.0, u_min, u_max, u, left) < 0) {
    const Vec2<double> corner = {of_both * (away[0].x + away[1].x), of_both * (away[0].y + away[1].y)};
    towards_plan(x, self, corner, 0.0, u_min, u_max, u, left);
  }
  after = next(x, u);
}

/// Makes u keep the distances if a plan of this period proves that this is possible. This covers
/// uncooperative neighbours alone, or one cooperative neighbour. Floor, ceiling and world are
/// violated no further.
/// @param after  state under u
/// @return whether u keeps the distances
bool Barrier::ensure_distances(std::span<const double> x, const Sight<double>& self, const Rows& rows,
                               std::span<const double> u_min, std::span<const double> u_max,
                               std::span<double> u, Next& after) const noexcept {
  const auto is_member = [](const Threat& threat) { return threat.behavior == Behavior::cooperative; };
  const auto tighter = [](const Threat& a, const Threat& b) { return a.reserve < b.reserve; };
  const Threat* const tightest = std::min_element(rows.threats.begin(), rows.threats.end(), tighter);
  if (rows.threats.empty() || tightest->reserve >= ample_) return false;
  if (rows.threats.size() > 1 && std::any_of(rows.threats.begin(), rows.threats.end(), is_member))
    return false;
  const auto left_of_world = [&](const Flown& there) {
    return options_.world < infinity ? left_of_walls(self, rows.part, there) : 0.0;
  };
  constexpr double touched = 1e-9;  // [m]
  const double walls = std::min(0.0, left_of_world(flown(x, u))),
               heights = rows.missed_of_heights(after) + touched;
  const auto left = [&](std::span<const double> one) {
    const Flown there = flown(x, one);
    const bool within = rows.missed_of_heights(there.after) <= heights && left_of_world(there) >= walls;
    return within ? left_by(self, rows, there) : -infinity;
  };
  const double part = is_member(*tightest) ? 0.5 : 1.0;
  const Tube& tube = tightest->tube;
  const double leaves =
      towards_plan(x, self, {part * tightest->plan.a.x, part * tightest->plan.a.y},
                   std::clamp(dt_ * tube.climb, -tube.room, tube.room), u_min, u_max, u, left);
  after = next(x, u);
  return leaves >= 0;
}

}  // namespace sightline
