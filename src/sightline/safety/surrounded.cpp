#include "sightline/safety/surrounded.hpp"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

Arena arena_of(const BarrierLaw& law, const BarrierPeriod& now) {
  Arena arena{.p = now.self.p,
              .v = {now.self.v.x, now.self.v.y},
              .disc = now.part * law.can.acceleration,
              .floor = law.can.climbs ? law.options.floor : -infinity,
              .ceiling = law.can.climbs ? law.options.ceiling : infinity,
              .world = law.options.world};
  for (std::size_t k = 0; law.can.thrust_count == 2 && k < 2; ++k) {
    const Vec2<double> g = law.can.turns ? rotate(now.self.d, law.can.thrusts[k]) : law.can.thrusts[k];
    arena.g[k] = {now.part * g.x, now.part * g.y};
  }
  return arena;
}

}  // namespace

bool is_surrounded(const BarrierLaw& law, const BarrierPeriod& now) noexcept {
  Bounded<Vec3<double>, most_neighbours> away;
  Vec2<double> sum{};
  for (const Threat& threat : now.threats) {
    if (threat.behavior != Behavior::uncooperative) continue;
    const Vec3<double> r = now.self.p - now.neighbours[static_cast<std::size_t>(threat.neighbour)].p;
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
  const double x = now.self.p.x + free_way * m.x, y = now.self.p.y + free_way * m.y;
  const bool free = std::max(std::abs(x), std::abs(y)) < law.options.world;
  return !(free && std::all_of(away.begin(), away.end(), falls_back));
}

bool choose_maneuver(const BarrierLaw& law, const BarrierPeriod& now, const NextState& after,
                     bool contradicted, EvasiveManeuver& maneuver) noexcept {
  const Arena arena = arena_of(law, now);
  Bounded<Chaser, most_neighbours> chasers;
  for (const Threat& threat : now.threats) {
    const Neighbour& n = now.neighbours[static_cast<std::size_t>(threat.neighbour)];
    Chaser& chaser = chasers.push_back({.p = n.p, .hard = n.d_hard + law.options.margin + 3 * n.sigma});
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
  maneuver = law.maneuvers.best(arena, chasers, maneuver, wanted + step);
  if (!contradicted && maneuver.left >= wanted) {
    Arena then = arena;
    then.p = after.p;
    then.v = after.v;
    Bounded<Chaser, most_neighbours> moved = chasers;
    for (Chaser& chaser : moved) {
      const Vec3<double> r = after.p - chaser.p;
      chaser.p = chaser.p + law.dt * chaser.v +
                 (chaser.speed * law.dt / std::max(norm(r), chaser.speed * law.dt + 1e-9)) * r;
    }
    if (law.maneuvers.left(then, moved, maneuver) >= wanted) return false;
  }
  maneuver.taken = true;
  return true;
}

void fly_maneuver(const BarrierLaw& law, const BarrierPeriod& now, EvasiveManeuver& maneuver,
                  std::span<double> u) noexcept {
  for (std::size_t k = 0; k < u.size(); ++k) u[k] = std::clamp(0.0, now.u_min[k], now.u_max[k]);
  const bool begun = maneuver.wait <= 0.5 * law.dt;
  const Vec2<double> a =
      begun ? EvasiveManeuvers::thrust(arena_of(law, now), maneuver.along) : Vec2<double>{};
  maneuver.wait = std::max(0.0, maneuver.wait - law.dt);
  const double climb = begun ? maneuver.climb : 0.0;
  law.reach_for(now.x, law.outcome_of(now.self, now.lagging, a, law.dt * climb), now.u_min, now.u_max, u);
}

}  // namespace sightline
