#include "sightline/safety/barrier_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/safety/barrier_check.hpp"

namespace sightline {
namespace {

/// The row that keeps the gap of a threat at one time of its plan.
BarrierRow keep_away(const BarrierLaw& law, const BarrierPeriod& now, int index, const Touch& touch) {
  const Threat& threat = now.threats[static_cast<std::size_t>(index)];
  const Vec2<double>& a = threat.plan.a;
  const double E = touch.shape.E, F = touch.shape.F;
  const EscapeShape left = law.plans.left(touch);
  const auto level = [&](const Vec2<double>& v) { return touch.n.x * v.x + touch.n.y * v.y; };
  Vec3<double> n = touch.n;
  if (touch.level) n.z = 0.0;  // the final height of the plan does not depend on the command
  const double risen = touch.level ? 0.0 : law.dt * n.z * threat.tube.climb;
  const double planned = dot(n, now.self.p) + E * level({now.self.v.x, now.self.v.y}) + risen;
  const double spare = touch.gap - threat.margin - (1.0 - law.options.rate * law.dt) * threat.reserve;
  if (threat.behavior == Behavior::cooperative) {
    // This robot provides half of the relative acceleration, and may use its share of the spare
    // reserve.
    const double lacks = now.neighbours[static_cast<std::size_t>(threat.neighbour)].lacks;
    const double least = planned + 0.5 * (F - left.F) * level(a) - law.options.share * spare + lacks;
    return {n, left.E, {}, least, Wall::none, index, touch.time, touch.slope, touch.curvature, left.e, false};
  }
  const double least = planned + F * level(a) - spare;
  BarrierRow row{n,           left.E,          {},     least, Wall::none, index, touch.time,
                 touch.slope, touch.curvature, left.e, false};
  if (law.can.thrust_lag > 0) {
    // rho contains the present settling(); the row requires that of the next sample.
    const Lagging& late = now.lagging;
    row.L = left.L;
    row.spread += law.per_beside * left.E;
    row.turn = now.turn_side * law.per_rate * left.E;
    row.least += touch.shape.L * level(late.a) - E * law.settling(now.beside, late.rate);
  }
  if (law.can.turns) {
    const Vec2<double> a_V = rotate<double>({now.self.d.x, -now.self.d.y}, a);
    row.thrust = {left.F * a_V.x, left.F * a_V.y};
  } else {
    row.least -= left.F * level(a);
  }
  return row;
}

void add_row(const BarrierLaw& law, BarrierRow row, BarrierPeriod& now) {
  if (law.can.climb_lag > 0) {
    // rho contains the present |beside|; the row requires that of the next sample.
    row.least -= now.beside;
    row.side = 1.0;
    now.rows.push_back(row);
    row.side = -1.0;
  }
  now.rows.push_back(row);
}

/// Adds rows at the times of the least gaps that a command leaves, where these are too small. With a
/// lag the command changes the gaps of later times most.
void add_later_rows(const BarrierLaw& law, const NextState& there, BarrierPeriod& now) {
  constexpr double slight = 1e-5;  // [m]
  for (std::size_t k = 0; k < now.threats.size(); ++k) {
    const Threat& threat = now.threats[k];
    if (!now.heeds(threat)) continue;
    const Escape rest = law.plans.with(rest_of(law, now, threat.tube, there), threat.plan.a);
    const double wanted = threat.margin + (1.0 - law.options.rate * law.dt) * threat.reserve - slight;
    for (std::size_t j = 0; j < rest.count && now.rows.size() + 2 <= most_half_spaces; ++j) {
      if (rest.touches[j].gap >= wanted) continue;
      const Touch later = law.plans.touch(threat.tube, threat.plan.a, rest.touches[j].time + law.dt);
      add_row(law, keep_away(law, now, static_cast<int>(k), later), now);
    }
  }
}

/// Distance that a piece leaves after 1 s at the present velocity, by its best face [m].
double left_of_piece(const ForbiddenPiece& piece, const BarrierPeriod& now) {
  const Vec3<double>&p = now.self.p, &v = now.self.v;
  double most = std::max(std::min(p.z, now.p_z) - piece.high + std::min(v.z, 0.0),
                         piece.low - std::max(p.z, now.p_z) - std::max(v.z, 0.0));
  for (const Face& face : piece.faces) {
    const double closing = std::min(face.n.x * v.x + face.n.y * v.y, 0.0);
    most = std::max(most, face.n.x * p.x + face.n.y * p.y - face.offset + closing);
  }
  return most;
}

/// Adds the face of a piece with the greatest reserve.
void bound_by_piece(const BarrierLaw& law, const ForbiddenPiece& piece, BarrierPeriod& now) {
  // A height with a lag must keep both the present height and that at which it comes to rest.
  const double above = std::min(now.self.p.z, now.p_z) - piece.high,
               below = piece.low - std::max(now.self.p.z, now.p_z);
  const BoundHeight end = above >= below ? BoundHeight{1.0, piece.high, above, Wall::zone}
                                         : BoundHeight{-1.0, piece.low, below, Wall::zone};
  if (!law.can.climbs && end.room >= 0) return;  // kept by the height, which does not change
  double most = law.can.climbs ? end.room : -infinity;
  BoundPlane best{};
  bool by_plane = false;
  for (const Face& face : piece.faces) {
    const BoundPlane plane = {face.n, -face.offset, Wall::zone};
    const double reserve = law.braked(plane, now.leading, now.settling, now.part);
    if (reserve > most) most = reserve, best = plane, by_plane = true;
  }
  if (by_plane)
    now.planes.push_back(best);
  else if (most > -infinity)
    now.heights.push_back(end);
}

}  // namespace

void add_neighbours(const BarrierLaw& law, BarrierPeriod& now) noexcept {
  const auto is_near = [&](const Threat& threat) { return now.heeds(threat) && threat.reserve < law.ample; };
  if (law.per_rate > 0 && std::any_of(now.threats.begin(), now.threats.end(), is_near)) {
    // |r| of the next sample is turn_side * r: a rate changes sign at a sample alone.
    BarrierRow row = row_of_wall({}, 0.0, std::min(0.0, now.turn_side * now.lagging.rate), Wall::none);
    row.turn = -now.turn_side;
    now.rows.push_back(row);
  }
  for (std::size_t k = 0; k < now.threats.size(); ++k) {
    const Threat& threat = now.threats[k];
    if (!now.heeds(threat)) continue;
    for (std::size_t j = 0; j < threat.plan.count; ++j) {
      add_row(law, keep_away(law, now, static_cast<int>(k), threat.plan.touches[j]), now);
    }
  }
}

void find_bounds(const BarrierLaw& law, BarrierPeriod& now) noexcept {
  const double z = now.self.p.z, floor = law.options.floor, ceiling = law.options.ceiling;
  if (law.can.climbs && floor > -infinity) now.heights.push_back({1.0, floor, z - floor, Wall::floor});
  if (law.can.climbs && ceiling < infinity)
    now.heights.push_back({-1.0, ceiling, ceiling - z, Wall::ceiling});
  if (law.options.world < infinity) {
    for (const BoundPlane& plane : {BoundPlane{{-1, 0}, law.options.world, Wall::x_max},
                                    BoundPlane{{1, 0}, law.options.world, Wall::x_min},
                                    BoundPlane{{0, -1}, law.options.world, Wall::y_max},
                                    BoundPlane{{0, 1}, law.options.world, Wall::y_min}})
      now.planes.push_back(plane);
  }
  Bounded<const ForbiddenPiece*, most_pieces> nearest;
  std::array<double, most_pieces> key;
  for (const ForbiddenPiece& piece : law.pieces) {
    const double left = left_of_piece(piece, now);
    if (nearest.size() == most_pieces && !(left < key[most_pieces - 1])) continue;
    if (nearest.size() < most_pieces) nearest.push_back(nullptr);
    std::size_t at = nearest.size() - 1;
    for (; at > 0 && key[at - 1] > left; --at) key[at] = key[at - 1], nearest[at] = nearest[at - 1];
    key[at] = left, nearest[at] = &piece;
  }
  for (const ForbiddenPiece* piece : nearest) bound_by_piece(law, *piece, now);
}

void add_walls(const BarrierLaw& law, Approach approach, BarrierPeriod& now) noexcept {
  const double kept_part = 1.0 - law.options.rate * law.dt, b = law.braking(now.part);
  // A joint plan climbs or sinks until it reaches the wall, and the height follows the command at
  // once.
  const auto kept_height = [&](double room) {
    return approach == Approach::at_once && room > 0 ? 0.0 : kept_part * room;
  };
  for (const BoundHeight& bound : now.heights) {
    const double least = bound.side * bound.level + kept_height(bound.room);
    now.rows.push_back(row_of_wall({0, 0, bound.side}, 0.0, least, bound.wall));
  }
  if (now.planes.empty()) return;
  const EscapeShape step = law.plans.shape_at_once(law.dt), end = law.plans.shape_at_once(0.0);
  for (const BoundPlane& plane : now.planes) {
    // The plan brakes straight away from the wall, until the velocity towards it is zero.
    const Vec3<double> n = {plane.n.x, plane.n.y, 0.0};
    const double at_rest = n.x * now.leading.v.x + n.y * now.leading.v.y - law.predicted.v,
                 counts = law.settling_part(at_rest, now.part);
    const double away = at_rest - counts * now.settling.v,
                 here = plane.offset + dot(n, now.leading.p) - law.predicted.p - counts * now.settling.p;
    const double t = law.stopping_time(away, now.part);
    const EscapeShape whole = t > law.dt ? law.plans.shape_at_once(t) : step,
                      left = t > law.dt ? law.plans.shape_at_once(t - law.dt) : end;
    const double later = here + whole.E * away + b * whole.F;
    const double wanted = kept_part * std::min(here, later);
    const double least =
        wanted - plane.offset - b * left.F + law.next_predicted.p + left.E * law.next_predicted.v;
    const double tau = law.can.thrust_lag;
    BarrierRow row = row_of_wall(n, left.E, least, plane.wall);
    if (tau > 0) {
      row.E = tau + left.E * (1.0 - law.can.drag * tau), row.L = left.E * tau;
      row.side = now.beside_side, row.spread = counts * law.per_beside * (tau + left.E);
      row.turn = counts * now.turn_side * law.per_rate * left.E;
    }
    now.rows.push_back(row);
  }
}

void add_cuts(const BarrierLaw& law, const NextState& there, BarrierPeriod& now) noexcept {
  if (law.can.thrust_lag > 0) return add_later_rows(law, there, now);
  const EscapeShape step = law.plans.shape(law.dt);
  const std::size_t before = now.rows.size();
  for (std::size_t i = 0; i < before && !now.rows.is_full(); ++i) {
    constexpr double tight = 2e-3, dip = 1e-5, longest = 0.25;  // [m], [m], [s]
    const BarrierRow& row = now.rows[i];
    if (row.threat < 0 || row.cut || row.curvature <= 0 || row.missed(there) < -tight) continue;
    // `less` is the change of the gap's slope against the plan; it moves the time of the least gap.
    const Threat& threat = now.threats[static_cast<std::size_t>(row.threat)];
    const double part = threat.behavior == Behavior::cooperative ? 0.5 : 1.0;
    const Vec2<double>& a = threat.plan.a;
    Vec2<double> dv = {there.v.x - step.e * now.self.v.x - part * step.E * a.x,
                       there.v.y - step.e * now.self.v.y - part * step.E * a.y};
    double less = row.e * (row.n.x * dv.x + row.n.y * dv.y);
    if (row.thrust.x != 0 || row.thrust.y != 0) {
      const Vec2<double> turned = rotate(there.d, rotate<double>({now.self.d.x, -now.self.d.y}, a));
      less += row.E * (row.n.x * (turned.x - a.x) + row.n.y * (turned.y - a.y));
    }
    const double shift = -(row.slope + less) / row.curvature;
    const double time = std::max(law.dt, row.time + std::clamp(shift, -longest, longest));
    if (0.5 * row.curvature * square(time - row.time) < dip) continue;
    now.rows[i].cut = true;
    BarrierRow later = keep_away(law, now, row.threat, law.plans.touch(threat.tube, a, time));
    if (row.side != 0) later.least -= now.beside, later.side = now.rows[i].side;
    now.rows.push_back(later);
  }
}

}  // namespace sightline
