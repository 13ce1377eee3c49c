// The part of the barrier for several uncooperative neighbours at once.
#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/safety/barrier_threats.hpp"

namespace sightline {

/// Search of a joint plan for several uncooperative neighbours. For neighbours whose own plan is
/// the candidate, the reserve is known.
struct Barrier::Joint {
  /// An uncooperative neighbour at the tightest time of its own plan. This one time rejects most
  /// candidates.
  struct Look {
    Vec3<double> q;
    double t, F, rho;
  };
  using Escapes = std::array<Escape, most_neighbours>;

  Joint(const EscapePlans& escape_plans, std::span<Threat*> uncooperative)
      : plans(escape_plans), all(uncooperative), kept(&first), tried(&second) {
    for (const Threat* threat : all) {
      const Tube& tube = threat->tube;
      const Touch& touch = threat->plan.touches[0];
      const double t = touch.time, E = touch.shape.E;
      looks.push_back({{tube.r.x + E * tube.w.x - t * tube.drift.x,
                        tube.r.y + E * tube.w.y - t * tube.drift.y, tube.r.z - t * tube.drift.z},
                       t,
                       touch.shape.F,
                       tube.rho0 + t * (tube.speed + 0.5 * tube.growth * t) + tube.spread * E});
    }
  }

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

double Barrier::join(const Sight<double>& self, Rows& rows) const noexcept {
  constexpr double near = 10.0;   // [m] bodies farther away do not surround the robot
  constexpr double spare = 0.02;  // [m] allowance for linearised rows of climbing plans
  Bounded<Threat*, most_neighbours> uncooperative;
  for (Threat& threat : rows.threats) {
    if (threat.behavior == Behavior::uncooperative && norm(threat.tube.r) < near)
      uncooperative.push_back(&threat);
  }
  if (uncooperative.size() < 2) return infinity;
  const auto tighter = [](const Threat* a, const Threat* b) { return a->reserve < b->reserve; };
  std::swap(uncooperative[0], *std::min_element(uncooperative.begin(), uncooperative.end(), tighter));
  const double least = uncooperative[0]->reserve;

  Joint joint(plans_, uncooperative);
  const auto enough = [&] { return joint.found && (joint.best >= least || joint.best >= ample_); };
  joint.consider({uncooperative[0]->plan.a, 0.0, 0.0});
  const double up = can_.climbs ? std::max(0.0, options_.ceiling - self.p.z) : 0.0;
  const double down = can_.climbs ? std::max(0.0, self.p.z - options_.floor) : 0.0;
  const double climb = rows.part * options_.authority * can_.climb;
  for (const auto& [speed, room] : {std::pair{0.0, 0.0}, {climb, up}, {-climb, down}}) {
    // With a lag of the height, a climbing plan increases the distance to the height of rest, and
    // so rho.
    if (enough() || (speed != 0 && can_.climb_lag > 0)) break;
    if (speed != 0 && room == 0) continue;
    for (const Vec2<double>& whole : joint_) {
      const Vec2<double> a_V = {rows.part * whole.x, rows.part * whole.y};
      const EscapeFlight flight = {can_.turns ? rotate(self.d, a_V) : a_V, speed, room};
      if (!joint.is_none(flight)) joint.consider(flight);
      if (enough()) break;
    }
  }
  if (!joint.found) return -infinity;
  // The rows of each neighbour keep this plan where it is its own; the others cannot lose `ample_`
  // in a period.
  if (std::max(joint.best, joint.reserve_of_others) >= ample_) return infinity;
  const EscapeFlight& taken = joint.taken;
  const double reserve = joint.best - spare;
  auto escape = joint.kept->begin();
  for (Threat* threat : uncooperative) {
    if (!Joint::own(*threat, taken)) {
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
                 step = std::min(std::abs(taken.climb) * dt_, taken.room);
    const double lag = options_.rate * dt_ * std::max(reserve, 0.0);
    rows.all.push_back(Rows::of_wall({0, 0, side}, 0.0, side * self.p.z + step - lag, Wall::none));
  }
  return reserve;
}

bool Barrier::is_surrounded(const Sight<double>& self, std::span<const Neighbour> neighbours,
                            const Rows& rows) const noexcept {
  Bounded<Vec3<double>, most_neighbours> away;
  Vec2<double> sum{};
  for (const Threat& threat : rows.threats) {
    if (threat.behavior != Behavior::uncooperative) continue;
    const Vec3<double> r = self.p - neighbours[static_cast<std::size_t>(threat.neighbour)].p;
    const Vec3<double> n = (1.0 / std::max(norm(r), 1e-9)) * r;
    sum = {sum.x + n.x, sum.y + n.y};
    away.push_back(n);
  }
  // The robot is not surrounded if all bodies are on one side of it and fall back when it flies
  // straight on. That way must be within the world.
  constexpr double opening = 0.5, free_way = 5.0;  // [-], [m]
  const double length = std::sqrt(dot(sum, sum));
  const Vec2<double> m = {sum.x / length, sum.y / length};
  const auto falls_back = [&](const Vec3<double>& n) { return n.x * m.x + n.y * m.y >= opening; };
  const double x = self.p.x + free_way * m.x, y = self.p.y + free_way * m.y;
  const bool free = std::max(std::abs(x), std::abs(y)) < options_.world;
  return !(free && std::all_of(away.begin(), away.end(), falls_back));
}

Arena Barrier::arena(const Sight<double>& self, double part) const noexcept {
  Arena arena{.p = self.p,
              .v = {self.v.x, self.v.y},
              .disc = part * can_.acceleration,
              .floor = can_.climbs ? options_.floor : -infinity,
              .ceiling = can_.climbs ? options_.ceiling : infinity,
              .world = options_.world};
  for (std::size_t k = 0; can_.thrust_count == 2 && k < 2; ++k) {
    const Vec2<double> g = can_.turns ? rotate(self.d, can_.thrusts[k]) : can_.thrusts[k];
    arena.g[k] = {part * g.x, part * g.y};
  }
  return arena;
}

/// Selects an evasive manoeuvre, unless one remains possible after the command that leads to
/// `after`.
/// @return whether the robot must fly the manoeuvre
bool Barrier::leave(const Sight<double>& self, const Next& after, bool contradicted,
                    std::span<const Neighbour> neighbours, const Rows& rows,
                    EvasiveManeuver& maneuver) const noexcept {
  const Arena arena = this->arena(self, rows.part);
  Bounded<Chaser, most_neighbours> chasers;
  for (const Threat& threat : rows.threats) {
    const Neighbour& n = neighbours[static_cast<std::size_t>(threat.neighbour)];
    Chaser& chaser = chasers.push_back({.p = n.p, .hard = n.d_hard + options_.margin + 3 * n.sigma});
    if (n.behavior == Behavior::cooperative) {
      chaser.v = n.v;
      chaser.p = n.p + n.age * n.v;
      continue;
    }
    // A moving body is assumed to keep its speed; a body at rest could move at its greatest speed.
    constexpr double moves = 0.1;  // [m/s]
    const double speed = norm(n.v);
    chaser.speed = speed > moves ? std::min(speed, n.speed_max) : n.speed_max;
    chaser.hard += chaser.speed * std::max(n.age, 0.0);
  }
  constexpr double enough = 0.25, more = 0.2, step = 0.05;  // [m]
  const double wanted = maneuver.taken ? enough + more : enough;
  maneuver = maneuvers_.best(arena, chasers, maneuver, wanted + step);
  if (!contradicted && maneuver.left >= wanted) {
    Arena then = arena;
    then.p = after.p;
    then.v = after.v;
    Bounded<Chaser, most_neighbours> moved = chasers;
    for (Chaser& chaser : moved) {
      const Vec3<double> r = after.p - chaser.p;
      chaser.p =
          chaser.p + dt_ * chaser.v + (chaser.speed * dt_ / std::max(norm(r), chaser.speed * dt_ + 1e-9)) * r;
    }
    if (maneuvers_.left(then, moved, maneuver) >= wanted) return false;
  }
  maneuver.taken = true;
  return true;
}

/// Sets u to the command that flies the manoeuvre; inputs without an effect on it are zero.
void Barrier::follow(std::span<const double> x, const Sight<double>& self, EvasiveManeuver& maneuver,
                     std::span<const double> u_min, std::span<const double> u_max,
                     std::span<double> u) const noexcept {
  for (std::size_t k = 0; k < u.size(); ++k) u[k] = std::clamp(0.0, u_min[k], u_max[k]);
  const bool begun = maneuver.wait <= 0.5 * dt_;
  const Vec2<double> a =
      begun ? EvasiveManeuvers::thrust(arena(self, part(u_min, u_max)), maneuver.along) : Vec2<double>{};
  maneuver.wait = std::max(0.0, maneuver.wait - dt_);
  const EscapeShape step = plans_.shape(dt_);
  const double climb = begun ? maneuver.climb : 0.0;
  reach_for(x, {step.e * self.v.x + step.E * a.x, step.e * self.v.y + step.E * a.y, self.p.z + dt_ * climb},
            u_min, u_max, u);
}

/// Makes the smallest change of u that leads to the wanted horizontal velocity and height after the
/// period, within the limits.
void Barrier::reach_for(std::span<const double> x, const std::array<double, 3>& wanted,
                        std::span<const double> u_min, std::span<const double> u_max,
                        std::span<double> u) const noexcept {
  const auto outcome = [&] {
    const Next n = next(x, u);
    return std::array<double, 3>{n.v.x, n.v.y, n.p.z};
  };
  // du = J' (J J' + tiny)^-1 (wanted - outcome), the least-norm solution.
  const std::array<double, 3> now = outcome();
  std::array<std::array<double, 3>, most_inputs> J{};
  for (std::size_t k = 0; k < u.size(); ++k) {
    if (can_.reach[k] == 0) continue;  // yaw would turn the plan's thrust
    constexpr double difference = 1e-3;
    const double at = u[k];
    u[k] = at + difference;
    const std::array<double, 3> there = outcome();
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
