#include "sightline/safety/evasive_maneuver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr int fine_steps = 36, coarse_steps = 16;
constexpr double fine = 0.06, coarse = 0.24;  // [s]
constexpr double tiny_distance = 1e-9;        // [m]
constexpr std::size_t most_chasers = 16;

constexpr std::array<double, 2> waits = {0.0, 0.8};  // [s]

/// Value of a manoeuvre. Of two with equal least distance, such as that of a body already too near,
/// the one with the shorter violation is better.
double worth(const EvasiveManeuver& plan) {
  constexpr double per_second = 0.02;  // [m/s]
  return plan.left - per_second * plan.within;
}

Vec2<double> turned(const Vec2<double>& along, double angle) {
  const SinCos<double> turn = sincos(angle);
  return rotate<double>({turn.cos, turn.sin}, along);
}

}  // namespace

EvasiveManeuvers::EvasiveManeuvers(double drag, double climb) : climb_(climb) {
  for (auto* step : {&fine_, &coarse_}) {
    const double h = step == &fine_ ? fine : coarse, ch = drag * h, e = std::exp(-ch);
    const double E = ch > 1e-6 ? (1 - e) / drag : h, F = ch > 1e-6 ? (h - E) / drag : 0.5 * h * h;
    *step = {h, e, E, F};
  }
  for (std::size_t i = 0; i < headings; ++i) heading_[i] = heading(i);
}

Vec2<double> EvasiveManeuvers::heading(std::size_t i) noexcept {
  return turned({1, 0}, 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(headings));
}

Vec2<double> EvasiveManeuvers::thrust(const Arena& arena, const Vec2<double>& along) noexcept {
  const auto& [g, h] = arena.g;
  const double area = g.x * h.y - g.y * h.x;
  if (area == 0) return {arena.disc * along.x, arena.disc * along.y};
  // along = s g + t h, scaled so that the larger of |s| and |t| is 1.
  const double s = (along.x * h.y - along.y * h.x) / area, t = (g.x * along.y - g.y * along.x) / area;
  const double most = std::max(std::abs(s), std::abs(t)), length = most > 0 ? 1.0 / most : 0.0;
  return {length * along.x, length * along.y};
}

void EvasiveManeuvers::judge(const Arena& arena, std::span<const Chaser> chasers,
                             std::span<EvasiveManeuver, width> plans) const noexcept {
  Pack a_x, a_y, climb, wait, x(arena.p.x), y(arena.p.y), z(arena.p.z), v_x(arena.v.x), v_y(arena.v.y);
  for (std::size_t i = 0; i < width; ++i) {
    const Vec2<double> a = thrust(arena, plans[i].along);
    const auto k = static_cast<int>(i);
    a_x.v[k] = a.x, a_y.v[k] = a.y, climb.v[k] = plans[i].climb, wait.v[k] = plans[i].wait;
  }
  struct Place {
    Pack x, y, z;
  };
  std::array<Place, most_chasers> body;
  const std::size_t count = std::min(chasers.size(), most_chasers);
  for (std::size_t j = 0; j < count; ++j) {
    const Vec3<double>& p = chasers[j].p;
    body[j] = {Pack(p.x), Pack(p.y), Pack(p.z)};
  }
  Pack least(1e6), t(0.0), within(0.0);  // within: time below the hard distance
  for (int k = 0; k < fine_steps + coarse_steps; ++k) {
    const Step& step = k < fine_steps ? fine_ : coarse_;
    const Pack waiting = t + Pack(0.5 * step.h) - wait;  // negative: not begun
    const Pack none(0.0), b_x = where_negative(waiting, none, a_x), b_y = where_negative(waiting, none, a_y);
    const Pack rise = where_negative(waiting, none, climb);
    const Pack from_x = x, from_y = y, from_z = z;
    x = clamp(x + step.E * v_x + step.F * b_x, -arena.world, arena.world);
    y = clamp(y + step.E * v_y + step.F * b_y, -arena.world, arena.world);
    z = clamp(z + step.h * rise, arena.floor, arena.ceiling);
    v_x = step.e * v_x + step.E * b_x;
    v_y = step.e * v_y + step.E * b_y;
    t = t + Pack(step.h);
    Pack now(1e6);
    for (std::size_t j = 0; j < count; ++j) {
      const Chaser& chaser = chasers[j];
      Place& q = body[j];
      const Pack r_x = from_x - q.x, r_y = from_y - q.y, r_z = from_z - q.z;
      // The body aims at the robot's position in the middle of the step.
      const Pack m_x = 0.5 * (from_x + x) - q.x, m_y = 0.5 * (from_y + y) - q.y,
                 m_z = 0.5 * (from_z + z) - q.z;
      const Pack gap = sqrt(m_x * m_x + m_y * m_y + m_z * m_z + Pack(tiny_distance * tiny_distance));
      const Pack reach = Pack(chaser.speed * step.h), over = gap - reach;
      const Pack part = where_negative(over, Pack(1.0), reach / gap);
      q.x = q.x + part * m_x + Pack(step.h * chaser.v.x);
      q.y = q.y + part * m_y + Pack(step.h * chaser.v.y);
      q.z = q.z + part * m_z + Pack(step.h * chaser.v.z);
      // Least distance on the straight relative path of this step.
      const Pack d_x = x - q.x - r_x, d_y = y - q.y - r_y, d_z = z - q.z - r_z;
      const Pack along = r_x * d_x + r_y * d_y + r_z * d_z;
      const Pack s =
          clamp(Pack(0.0) - along / (d_x * d_x + d_y * d_y + d_z * d_z + Pack(tiny_distance * tiny_distance)),
                0.0, 1.0);
      const Pack n_x = r_x + s * d_x, n_y = r_y + s * d_y, n_z = r_z + s * d_z;
      const Pack left = sqrt(n_x * n_x + n_y * n_y + n_z * n_z) - Pack(chaser.hard);
      now = where_negative(left - now, left, now);
    }
    least = where_negative(now - least, now, least);
    within = within + where_negative(now, Pack(step.h), none);
  }
  for (std::size_t i = 0; i < width; ++i) {
    const auto k = static_cast<int>(i);
    plans[i].left = least[k];
    plans[i].within = within[k];
  }
}

double EvasiveManeuvers::left(const Arena& arena, std::span<const Chaser> chasers,
                              const EvasiveManeuver& plan) const noexcept {
  std::array<EvasiveManeuver, width> plans;
  plans.fill(plan);
  judge(arena, chasers, plans);
  return plans[0].left;
}

EvasiveManeuver EvasiveManeuvers::best(const Arena& arena, std::span<const Chaser> chasers,
                                       const EvasiveManeuver& before, double enough) const noexcept {
  std::array<EvasiveManeuver, width> pack;
  std::size_t filled = 0;
  EvasiveManeuver best;
  const auto flush = [&] {
    if (filled == 0) return;
    for (std::size_t i = filled; i < width; ++i) pack[i] = pack[filled - 1];
    judge(arena, chasers, pack);
    for (std::size_t i = 0; i < filled; ++i) {
      if (worth(pack[i]) > worth(best)) best = pack[i];
    }
    filled = 0;
  };
  const auto consider = [&](const Vec2<double>& along, double climb, double wait) {
    pack[filled++] = {along, climb, wait};
    if (filled == width) flush();
  };
  const auto beside = [&](const EvasiveManeuver& plan, double angle, double rise, double later) {
    consider(plan.along, plan.climb, plan.wait);
    for (const double side : {-1.0, 1.0}) {
      consider(turned(plan.along, side * angle), plan.climb, plan.wait);
      consider(plan.along, std::clamp(plan.climb + side * rise * climb_, -climb_, climb_), plan.wait);
      consider(plan.along, plan.climb, std::max(0.0, plan.wait + side * later));
    }
    flush();
  };
  if (before.taken) beside(before, 0.06, 0.2, 0.05);
  if (best.left >= enough) return best;
  for (const double wait : waits) {
    for (const double climb : {climb_, 0.0, -climb_}) {
      for (const Vec2<double>& along : heading_) consider(along, climb, wait);
      if (wait == 0) consider({}, climb, 0.0);
      if (best.left >= enough) return best;
      if (climb_ == 0) break;
    }
  }
  flush();
  beside(EvasiveManeuver(best), 0.15, 0.5, 0.2);
  beside(EvasiveManeuver(best), 0.07, 0.25, 0.1);
  return best;
}

}  // namespace sightline
