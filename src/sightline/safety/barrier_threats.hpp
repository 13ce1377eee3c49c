/// What the sources of Barrier share: the next state, the neighbours and the rows.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/base/bounded.hpp"
#include "sightline/safety/barrier.hpp"
#include "sightline/safety/projection.hpp"

namespace sightline {

inline constexpr double far_away = 1e6;  // [m] what is farther cannot matter

/// Away from the bounds of the world, in the order of Wall from x_max on and y_max on.
inline constexpr std::array<Vec2<double>, 4> inward = {{{-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
inline constexpr std::array<Wall, 4> bounds_of_world = {Wall::x_max, Wall::x_min, Wall::y_max, Wall::y_min};

/// What of the next sampled state counts.
struct Barrier::Next {
  Vec3<double> p;  // as Barrier::settled()
  Vec2<double> d, v;
  double beside = 0.0;  // the height, over that at which the robot comes to rest
};

/// Where a command leads within the period.
struct Barrier::Flown {
  Bounded<Vec3<double>, EscapePlans::most_parts> between;  // at the ends of all parts but the last
  Next after;
};

/// A neighbour and the plan to flee it.
struct Barrier::Threat {
  Tube tube{};
  Escape plan{};
  Behavior behavior = Behavior::uncooperative;
  int neighbour = -1;
  double reserve = 0.0;  // that the rows keep: of this plan, or of all that it is for [m]
  double margin = 0.0;   // that they keep beside it [m]
};

/// n . (p+ + E v+ + R(d+) thrust) >= least at the next sample.
struct Barrier::Row {
  Vec3<double> n;
  double E;             // [s]
  Vec2<double> thrust;  // what the plan adds after it, in V [m]
  double least;         // [m]
  Wall wall;
  int threat;                     // or -1
  double time, slope, curvature;  // of the threat's gap at the time that the row holds
  double e;                       // what a velocity is worth then
  bool cut;                       // a second row holds the time to which the command has moved it
  double side = 0.0;              // 1 or -1: less side * beside, of a height that follows late

  double value(const Next& next) const {
    const Vec2<double> push = rotate(next.d, thrust);
    return dot(n, next.p) + n.x * (E * next.v.x + push.x) + n.y * (E * next.v.y + push.y) -
           side * next.beside;
  }
  /// By how much it is missed [m].
  double missed(const Next& next) const { return least - value(next); }
};

struct Barrier::Rows {
  /// By how much floor or ceiling are missed most [m], >= 0.
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

  double part;    // of the acceleration, which the limits leave
  double beside;  // by how much the height is not yet that at which the robot comes to rest [m]
  Bounded<Threat, most_neighbours> threats;
  Bounded<Row, most_half_spaces> all;
};

}  // namespace sightline
