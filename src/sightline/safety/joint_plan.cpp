#include "sightline/safety/joint_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sightline/safety/barrier_rows.hpp"

namespace sightline {
namespace {

/// Search of a joint plan for several uncooperative neighbours. For neighbours whose own plan is
/// the candidate, the reserve is known.
struct JointPlan {
  /// An uncooperative neighbour at the tightest time of its own plan. This one time rejects most
  /// candidates.
  struct Look {
    Vec3<double> q;
    double t, F, rho;
  };
  using Escapes = std::array<Escape, most_neighbours>;

  JointPlan(const EscapePlans& escape_plans, std::span<Threat*> uncooperative)
      : plans(escape_plans), all(uncooperative), kept(&first), tried(&second) {
    for (const Threat* threat : all) {
      const Tube& tube = threat->tube;
      const Touch& touch = threat->plan.touches[0];
      const double t = touch.time, E = touch.shape.E;
      const double L = touch.shape.L;
      looks.push_back(
          {{tube.r.x + E * tube.w.x - t * tube.drift.x + L * tube.s.x,
            tube.r.y + E * tube.w.y - t * tube.drift.y + L * tube.s.y, tube.r.z - t * tube.drift.z},
           t,
           touch.shape.F,
           tube.rho0 + t * (tube.speed + 0.5 * tube.growth * t) + tube.spread * E});
    }
  }

  JointPlan(const JointPlan&) = delete;  // it points into itself
  JointPlan& operator=(const JointPlan&) = delete;

  static bool own(const Threat& threat, const EscapeFlight& flight) {
    return flight.climb == 0 && threat.plan.a.x == flight.a.x && threat.plan.a.y == flight.a.y;
  }
  /// Collects neighbours with another own plan in `others`. @return the least reserve of the
  /// neighbours whose own plan the flight is [m]
  double sort(const EscapeFlight& flight) {
    double reserve = infinity;
    others.clear();
    for (const Threat* threat : all) {
      if (own(*threat, flight))
        reserve = std::min(reserve, threat->reserve);
      else
        others.push_back(&threat->tube);
    }
    return reserve;
  }

  /// Whether one time of each neighbour shows that the flight is no better than the best.
  bool is_none(const EscapeFlight& flight) {
    for (Look& look : looks) {
      const double x = look.q.x + look.F * flight.a.x, y = look.q.y + look.F * flight.a.y,
                   z = look.q.z + std::clamp(flight.climb * look.t, -flight.room, flight.room);
      if (x * x + y * y + z * z >= square(std::max(0.0, best + look.rho))) continue;
      std::swap(looks[0], look);  // tried first: it is likely to reject the next flights, too
      return true;
    }
    return false;
  }

  /// Takes the flight if it is better than the best.
  void consider(const EscapeFlight& flight) {
    const double own_reserve = sort(flight);
    if (own_reserve < best || !plans.with(others.items(), flight, best, *tried)) return;
    double beside = infinity;
    for (std::size_t k = 0; k < others.size(); ++k) beside = std::min(beside, (*tried)[k].reserve());
    if (beside < best) return;
    std::swap(kept, tried);
    best = std::min(own_reserve, beside);
    reserve_of_others = beside;
    taken = flight;
    found = true;
  }

  const EscapePlans& plans;
  std::span<Threat*> all;
  Bounded<Look, most_neighbours> looks;
  Bounded<const Tube*, most_neighbours> others;
  Escapes first, second;  // plans of `taken` and of the candidate, for `others`
  Escapes *kept, *tried;
  double best = 0.0;               // the reserve of `taken` [m]
  double reserve_of_others = 0.0;  // the same over `others` alone [m]
  bool found = false;
  EscapeFlight taken{};
};

}  // namespace

double join_plans(const BarrierLaw& law, BarrierPeriod& now) noexcept {
  constexpr double near = 10.0;   // [m] bodies farther away do not surround the robot
  constexpr double spare = 0.02;  // [m] allowance for linearised rows of climbing plans
  Bounded<Threat*, most_neighbours> uncooperative;
  for (Threat& threat : now.threats) {
    if (threat.behavior == Behavior::uncooperative && norm(threat.tube.r) < near)
      uncooperative.push_back(&threat);
  }
  if (uncooperative.size() < 2) return infinity;
  const auto tighter = [](const Threat* a, const Threat* b) { return a->reserve < b->reserve; };
  std::swap(uncooperative[0], *std::min_element(uncooperative.begin(), uncooperative.end(), tighter));
  const double least = uncooperative[0]->reserve;

  JointPlan joint(law.plans, uncooperative);
  const auto enough = [&] { return joint.found && (joint.best >= least || joint.best >= law.ample); };
  joint.consider({uncooperative[0]->plan.a, 0.0, 0.0});
  const double up = law.can.climbs ? std::max(0.0, law.options.ceiling - now.self.p.z) : 0.0;
  const double down = law.can.climbs ? std::max(0.0, now.self.p.z - law.options.floor) : 0.0;
  const double climb = now.part * law.options.authority * law.can.climb;
  for (const auto& [speed, room] : {std::pair{0.0, 0.0}, {climb, up}, {-climb, down}}) {
    // With a lag of the height, a climbing plan increases the distance to the height of rest, and
    // so rho.
    if (enough() || (speed != 0 && law.can.climb_lag > 0)) break;
    if (speed != 0 && room == 0) continue;
    for (const Vec2<double>& whole : law.joint) {
      const Vec2<double> a_V = {now.part * whole.x, now.part * whole.y};
      const EscapeFlight flight = {law.can.turns ? rotate(now.self.d, a_V) : a_V, speed, room};
      if (!joint.is_none(flight)) joint.consider(flight);
      if (enough()) break;
    }
  }
  if (!joint.found) return -infinity;
  // The rows of each neighbour keep this plan where it is its own; the others cannot lose
  // `law.ample` in a period.
  if (std::max(joint.best, joint.reserve_of_others) >= law.ample) return infinity;
  const EscapeFlight& taken = joint.taken;
  const double reserve = joint.best - spare;
  auto escape = joint.kept->begin();
  for (Threat* threat : uncooperative) {
    if (!JointPlan::own(*threat, taken)) {
      threat->tube.climb = taken.climb;
      threat->tube.room = taken.room;
      threat->plan = *escape++;
    }
    threat->reserve = reserve;
    threat->margin = spare;
  }
  if (taken.climb != 0) {
    // Height counts at every time until the plan is level. It may fall behind by the decay that
    // `rate` allows.
    const double side = std::copysign(1.0, taken.climb),
                 step = std::min(std::abs(taken.climb) * law.dt, taken.room);
    const double lag = law.options.rate * law.dt * std::max(reserve, 0.0);
    now.rows.push_back(row_of_wall({0, 0, side}, 0.0, side * now.self.p.z + step - lag, Wall::none));
  }
  return reserve;
}

}  // namespace sightline
