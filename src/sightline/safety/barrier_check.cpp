#include "sightline/safety/barrier_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/safety/barrier_rows.hpp"

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

constexpr double unproven = 1e-9;  // [m] missed by a command after which no distance is proven

struct CommandCheck {
  /// Required reserve of a plan after the period [m]. A tolerance lets the reserve fall by half of
  /// the margin.
  double required(const Threat& threat) const {
    constexpr double drift = 5e-4;  // [m]
    const double used = law.options.rate * law.dt;
    return threat.margin + (1.0 - used) * threat.reserve - used * (0.5 * threat.margin + drift);
  }

  /// Reserve beyond the requirement against all neighbours [m]; >= 0: the command is accepted.
  double left_by(const Flown& flown) const {
    double least = left_of_chases(flown);
    for (const Threat& threat : now.threats) {
      if (threat.behavior == Behavior::cooperative) least = std::min(least, left_of_pair(threat, flown));
    }
    return least;
  }

  /// The same against uncooperative neighbours: for the motion within the period, and for the rest
  /// of the plan.
  double left_of_chases(const Flown& flown) const {
    const NextState& after = flown.after;
    // The flown motion contains what settles.
    const double settled = law.settling(now.beside, now.lagging.rate);
    double least = infinity;
    Bounded<Tube, most_neighbours> rest;
    Bounded<const Threat*, most_neighbours> of;
    for (const Threat& threat : now.threats) {
      if (threat.behavior == Behavior::cooperative || threat.reserve >= law.ample) continue;
      const Tube& tube = threat.tube;
      const double wanted = required(threat);
      for (std::size_t k = 0; k < flown.between.size(); ++k) {
        const double s = law.dt * static_cast<double>(k + 1) / law.parts;
        const Vec3<double> q = tube.r + (flown.between[k] - now.self.p) - s * tube.drift;
        const double rho = tube.rho0 - now.beside + s * (tube.speed + 0.5 * tube.growth * s) +
                           (tube.spread - settled) * law.plans.E(s);
        least = std::min(least, norm(q) - rho - wanted);
      }
      rest.push_back(rest_of(law, now, tube, after));
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
          law.can.turns ? rotate(after.d, rotate<double>({now.self.d.x, -now.self.d.y}, leading.plan.a))
                        : leading.plan.a;
      law.plans.with(tubes.items(), {a, leading.tube.climb, rest[first].room}, -infinity, plans);
      for (std::size_t k = first; k < end; ++k)
        least = std::min(least, plans[k - first].reserve() - required(*of[k]));
      first = end;
    }
    if (now.proven && !of.empty() && least >= 0) {
      const double sampled = std::min(norm(of[0]->tube.r) - of[0]->tube.rho0, plans[0].now);
      if (sampled + law.options.margin < dip() ||
          !law.plans.keeps(rest[0], of[0]->plan.a, law.proven_least()))
        least = -unproven;
    }
    return least;
  }

  /// Bound of the amount by which the distance from a point falls, between two samples, below its
  /// least at both [m].
  double dip() const {
    const double lifted = law.can.climb_lag > 0 ? 2 * law.can.climb / law.can.climb_lag : 0.0,
                 pushed = law.can.thrust_most * (1.0 + law.can.lift * lifted) + lifted +
                          law.can.drag * norm(now.self.v) + law.options.residual_acceleration;
    const double fast = norm(now.self.v) + law.can.rise + law.dt * pushed,
                 near = norm(now.threats[0].tube.r) - now.beside - law.dt * fast;
    return near > 0 ? 0.125 * square(law.dt / law.parts) * (fast * fast / near + pushed) : infinity;
  }

  /// The same against a cooperative neighbour: at any time this robot may use its share of the
  /// spare reserve.
  double left_of_pair(const Threat& threat, const Flown& flown) const {
    const Tube& tube = threat.tube;
    const Vec2<double> own = {0.5 * threat.plan.a.x, 0.5 * threat.plan.a.y};
    const auto beside_plan = [&](const Vec3<double>& p, const EscapeShape& at) {
      return Vec3<double>{p.x - now.self.p.x - at.E * now.self.v.x - at.F * own.x,
                          p.y - now.self.p.y - at.E * now.self.v.y - at.F * own.y, p.z - now.self.p.z};
    };
    const double wanted = required(threat);
    const auto left = [&](double t, const EscapeShape& at, const Vec3<double>& moved) {
      const Vec3<double> q = {tube.r.x + at.E * tube.w.x + at.F * threat.plan.a.x,
                              tube.r.y + at.E * tube.w.y + at.F * threat.plan.a.y, tube.r.z};
      const double length = norm(q),
                   gap = length - tube.rho0 - t * (tube.speed + 0.5 * tube.growth * t) - tube.spread * at.E;
      return dot(q, moved) / std::max(length, 1e-9) + law.options.share * (gap - wanted);
    };
    double least = infinity;
    for (std::size_t k = 0; k < flown.between.size(); ++k) {
      const double t = law.dt * static_cast<double>(k + 1) / law.parts;
      const EscapeShape at = law.plans.shape(t);
      least = std::min(least, left(t, at, beside_plan(flown.between[k], at)));
    }
    const EscapeShape step = law.plans.shape(law.dt);
    const Vec3<double> p = beside_plan(flown.after.p, step);
    const Vec2<double> v = {flown.after.v.x - step.e * now.self.v.x - step.E * own.x,
                            flown.after.v.y - step.e * now.self.v.y - step.E * own.y};
    return std::min(least, least_over(law.dt, [&](double t) {
                      const double E = law.plans.E(t - law.dt);
                      return left(t, law.plans.shape(t), {p.x + E * v.x, p.y + E * v.y, p.z});
                    }));
  }

  /// Distance to the planes that bound the robot beyond the requirement [m], after braking and
  /// within the period. A bound that is already exceeded must not be exceeded further.
  double left_of_walls(const Flown& flown) const {
    constexpr double touched = 1e-6;  // [m]
    const double astray = law.options.residual_acceleration * law.plans.F(law.options.command_delay + law.dt);
    const BarrierLaw::Point after = law.leading(flown.after.p, flown.after.v, flown.after.lagging);
    const BarrierLaw::Deviation settling =
        law.settling_of_leading(flown.after.beside, flown.after.lagging.rate);
    double least = infinity;
    for (const BoundPlane& plane : now.planes) {
      const double here = law.braked(plane, now.leading, now.settling, now.part);
      const double wanted = here > 0 ? (1.0 - law.options.rate * law.dt) * here : here;
      const double p_off = law.next_predicted.p - law.predicted.p,
                   v_off = law.next_predicted.v - law.predicted.v;
      const Vec3<double> p_after = after.p - p_off * Vec3<double>{plane.n.x, plane.n.y, 0.0};
      const Vec2<double> v_after = {after.v.x - v_off * plane.n.x, after.v.y - v_off * plane.n.y};
      least = std::min(least, law.braked(plane, {p_after, v_after}, settling, now.part) - wanted);
      for (const Vec3<double>& p : flown.between)
        least =
            std::min(least, plane.offset + plane.n.x * p.x + plane.n.y * p.y - astray - std::min(here, 0.0));
    }
    return least + touched;
  }

  /// If u leaves less than 0, replaces u by the nearest command on the line to the plan's own
  /// command that leaves at least 0.
  /// @param a, rise  the plan's acceleration [m/s^2], and its climb within the period [m]
  /// @param known  what the plan's own command leaves by proof, unless it misses a wall [m], or -infinity
  /// @param left  reserve of a command beyond the requirement [m]
  /// @return the remaining reserve [m]; if less than 0, no command suffices, and u is the better of
  ///         the two
  template <class Left>
  double towards_plan(const Vec2<double>& a, double rise, double known, std::span<double> u,
                      const Left& left) const {
    const double leaves_now = left(u);
    if (leaves_now >= 0) return leaves_now;
    std::array<double, most_inputs> command{}, tried{};
    const auto planned = std::span(command).first(u.size());
    for (std::size_t k = 0; k < u.size(); ++k) planned[k] = std::clamp(0.0, now.u_min[k], now.u_max[k]);
    const bool is_known = known > -infinity;
    const BarrierLaw::Outcome wanted = is_known ? law.outcome_of_held(now.self, law.next(now.x, planned), a)
                                                : law.outcome_of(now.self, now.lagging, a, rise);
    law.reach_for(now.x, wanted, now.u_min, now.u_max, planned);
    double leaves = left(planned);
    if (is_known && leaves > -infinity) leaves = std::max(leaves, known);
    if (leaves <= leaves_now) return leaves_now;
    const auto between = [&](double part, std::size_t k) {
      return std::clamp(planned[k] + part * (u[k] - planned[k]), now.u_min[k], now.u_max[k]);
    };
    constexpr int halvings = 4;
    double share = 0.0, more = 0.5;
    for (int round = 0; round < halvings && leaves >= 0; ++round, more *= 0.5) {
      for (std::size_t k = 0; k < u.size(); ++k) tried[k] = between(share + more, k);
      const double left_then = left(std::span<const double>(tried).first(u.size()));
      if (left_then >= 0) share += more, leaves = left_then;
    }
    for (std::size_t k = 0; k < u.size(); ++k) u[k] = between(share, k);
    return leaves;
  }

  const BarrierLaw& law;
  const BarrierPeriod& now;
};

}  // namespace

Tube rest_of(const BarrierLaw& law, const BarrierPeriod& now, const Tube& tube,
             const NextState& after) noexcept {
  const EscapeShape step = law.plans.shape(law.dt);
  Tube later = tube;
  later.r = tube.r + (after.p - now.self.p) - law.dt * tube.drift;
  later.w = after.v;
  later.rho0 += law.dt * (tube.speed + 0.5 * tube.growth * law.dt) + tube.spread * step.E +
                std::abs(after.beside) - now.beside;
  later.speed += law.dt * tube.growth;
  later.spread *= step.e;
  later.room = std::max(0.0, tube.room - std::copysign(1.0, tube.climb) * (after.p.z - now.self.p.z));
  if (law.can.thrust_lag > 0) {
    // What has settled is in the next state.
    const double settled = law.settling(now.beside, now.lagging.rate);
    later.s = after.lagging.a;
    later.rho0 -= settled * step.E;
    later.spread += law.settling(after.beside, after.lagging.rate) - settled * step.e;
  }
  return later;
}

void ensure_walls(const BarrierLaw& law, const BarrierPeriod& now, std::span<double> u,
                  NextState& after) noexcept {
  if (now.planes.empty()) return;
  const CommandCheck check{law, now};
  const auto nearer = [&](const BoundPlane& one, const BoundPlane& other) {
    return law.braked(one, now.leading, now.settling, now.part) <
           law.braked(other, now.leading, now.settling, now.part);
  };
  const auto left = [&](std::span<const double> one) { return check.left_of_walls(law.flown(now.x, one)); };
  auto nearest = now.planes;
  const bool alone = nearest.size() == 1;
  std::partial_sort(nearest.begin(), nearest.begin() + (alone ? 1 : 2), nearest.end(), nearer);
  const double b = now.part * law.b;
  const Vec2<double>& n = nearest[0].n;
  if (check.towards_plan({b * n.x, b * n.y}, 0.0, -infinity, u, left) < 0 && !alone) {
    const Vec2<double>& m = nearest[1].n;
    const Vec2<double> sum = {n.x + m.x, n.y + m.y};
    const double of_both = b * (dot(n, m) > 0 ? 1.0 / norm(sum.x, sum.y) : std::sqrt(0.5));
    check.towards_plan({of_both * sum.x, of_both * sum.y}, 0.0, -infinity, u, left);
  }
  after = law.next(now.x, u);
}

bool ensure_distances(const BarrierLaw& law, const BarrierPeriod& now, std::span<double> u,
                      NextState& after) noexcept {
  const auto is_member = [](const Threat& threat) { return threat.behavior == Behavior::cooperative; };
  const auto tighter = [](const Threat& a, const Threat& b) { return a.reserve < b.reserve; };
  const Threat* const tightest = std::min_element(now.threats.begin(), now.threats.end(), tighter);
  if (now.threats.empty() || tightest->reserve >= law.ample) return false;
  if (now.threats.size() > 1 && std::any_of(now.threats.begin(), now.threats.end(), is_member)) return false;
  const CommandCheck check{law, now};
  const auto left_of_world = [&](const Flown& there) {
    return now.planes.empty() ? 0.0 : check.left_of_walls(there);
  };
  constexpr double touched = 1e-9;  // [m]
  const double walls = std::min(0.0, left_of_world(law.flown(now.x, u))),
               heights = now.missed_of_heights(after) + touched;
  const auto left = [&](std::span<const double> one) {
    const Flown there = law.flown(now.x, one);
    const bool within = now.missed_of_heights(there.after) <= heights && left_of_world(there) >= walls;
    return within ? check.left_by(there) : -infinity;
  };
  const double part = is_member(*tightest) ? 0.5 : 1.0;
  const Tube& tube = tightest->tube;
  const double leaves = check.towards_plan({part * tightest->plan.a.x, part * tightest->plan.a.y},
                                           std::clamp(law.dt * tube.climb, -tube.room, tube.room),
                                           now.proven ? 0.0 : -infinity, u, left);
  after = law.next(now.x, u);
  return leaves >= 0;
}

}  // namespace sightline
