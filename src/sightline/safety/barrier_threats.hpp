/// Types that the sources of Barrier share: the next state, the neighbours and the rows.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/barrier.hpp"
#include "sightline/base/bounded.hpp"
#include "sightline/safety/projection.hpp"

namespace sightline {

inline constexpr double far_away = 1e6;  // [m] bodies farther away are ignored

/// Inward normals of the world's bounds, in the order of bounds_of_world.
inline constexpr std::array<Vec2<double>, 4> inward = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
inline constexpr std::array<Wall, 4> bounds_of_world = {Wall::x_max, Wall::x_min, Wall::y_max, Wall::y_min};

/// The next sampled state, as far as the rows depend on it.
struct Barrier::Next {
  Vec3<double> p;  // position, as Barrier::settled()
  Vec2<double> d, v;
  double beside = 0.0;  // height less the height at which the robot comes to rest [m]
};

/// Positions within the period under a command.
struct Barrier::Flown {
  Bounded<Vec3<double>, EscapePlans::most_parts> between;  // at the ends of all steps but the last
  Next after;
};

/// A neighbour and the plan to evade it.
struct Barrier::Threat {
  Tube tube{};
  Escape plan{};
  Behavior behavior = Behavior::uncooperative;
  int neighbour = -1;
  double reserve = 0.0;  // that the rows keep: of this plan, or of the joint plan [m]
  double margin = 0.0;   // that the rows keep in addition [m]
};

/// n . (p+ + E v+ + R(d+) thrust) >= least at the next sample.
struct Barrier::Row {
  Vec3<double> n;
  double E;             // [s]
  Vec2<double> thrust;  // displacement by the rest of the plan, in V [m]
  double least;         // [m]
  Wall wall;
  int threat;                     // index, or -1
  double time, slope, curvature;  // of the threat's gap at the row's time
  double e;                       // decay of a velocity until then
  bool cut;                       // a second row exists at the gap's minimum under the command
  double side = 0.0;              // 1 or -1: subtracts side * beside, for a height with a lag; else 0

  double value(const Next& next) const {
    const Vec2<double> push = rotate(next.d, thrust);
    return dot(n, next.p) + n.x * (E * next.v.x + push.x) + n.y * (E * next.v.y + push.y) -
           side * next.beside;
  }
  /// Amount by which the row is missed [m]; negative: it is kept.
  double missed(const Next& next) const { return least - value(next); }
};

struct Barrier::Rows {
  /// Largest amount by which a floor or ceiling row is missed [m], >= 0.
  double missed_of_heights(const Next& next) const {
    double most = 0.0;
    for (const Row& row : all) {
      if (row.wall == Wall::floor || row.wall == Wall::ceiling) most = std::max(most, row.missed(next));
    }
    return most;
  }
  static Row of_wall(const Vec3<double>& n, double E, double least, Wall wall) {
    return {n, E, {}, least, wall, -1, 0.0, 0.0, 0.0, 0.0, false};
  }

  double part;    // of the acceleration, within the limits
  double beside;  // |height less the height at which the robot comes to rest| [m]
  Bounded<Threat, most_neighbours> threats;
  Bounded<Row, most_half_spaces> all;
};

}  // namespace sightline
