/// What a robot knows in one period: state, limits, neighbours, and the rows of its command.
#pragma once

#include <algorithm>
#include <span>

#include "sightline/barrier.hpp"
#include "sightline/base/bounded.hpp"
#include "sightline/safety/barrier_law.hpp"
#include "sightline/safety/projection.hpp"

namespace sightline {

enum class Heeded { all, members };

/// A neighbour and the plan to evade it.
struct Threat {
  Tube tube{};
  Escape plan{};
  Behavior behavior = Behavior::uncooperative;
  int neighbour = -1;
  double reserve = 0.0;  // that the rows keep: of this plan, or of the joint plan [m]
  double margin = 0.0;   // that the rows keep in addition [m]
};

/// n . (p+ + E v+ + L a+ + R(d+) thrust) >= least at the next sample.
struct BarrierRow {
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
  double spread = 1.0;            // factor of beside
  double L = 0.0;                 // of an acceleration that lags [s^2]
  double turn = 0.0;              // subtracts turn * rate [m s/rad]

  double value(const NextState& next) const {
    const Vec2<double> push = rotate(next.d, thrust), &a = next.lagging.a;
    const double at_once = dot(n, next.p) + n.x * (E * next.v.x + push.x) + n.y * (E * next.v.y + push.y) -
                           side * spread * next.beside;
    return at_once + L * (n.x * a.x + n.y * a.y) - turn * next.lagging.rate;
  }
  /// Amount by which the row is missed [m]; negative: it is kept.
  double missed(const NextState& next) const { return least - value(next); }
};

/// Greatest number of forbidden pieces that a robot considers, those that leave least.
inline constexpr std::size_t most_pieces = 8;

/// A bound of the height z: side (z - level) >= 0.
struct BoundHeight {
  double side;   // 1: from below, -1: from above
  double level;  // [m]
  double room;   // side (z - level) now [m]
  Wall wall;
};

struct BarrierPeriod {
  /// Largest amount by which a row of the height alone is missed [m], >= 0.
  double missed_of_heights(const NextState& next) const {
    double most = 0.0;
    for (const BarrierRow& row : rows) {
      if (row.wall != Wall::none && row.n.z != 0) most = std::max(most, row.missed(next));
    }
    return most;
  }

  bool heeds(const Threat& threat) const {
    return heeded == Heeded::all || threat.behavior == Behavior::cooperative;
  }

  std::span<const double> x, u_min, u_max;
  std::span<const Neighbour> neighbours;
  Sight<double> self;  // as BarrierLaw::settled()
  double part;         // of the acceleration, within the limits
  double beside;       // |height less the height at which the robot comes to rest| [m]
  Lagging lagging;
  double p_z;                        // height [m]
  BarrierLaw::Point leading{};       // of `self`
  BarrierLaw::Deviation settling{};  // of `leading`
  double beside_side = 1.0;          // sign of NextState::beside
  double turn_side = 1.0;            // sign of the yaw rate at the next sample
  Heeded heeded = Heeded::all;       // neighbours with rows; an evasive manoeuvre avoids the others
  Vec2<double> plan_before{};        // EvasiveManeuver::plan
  bool proven = false;               // the one neighbour's plan certainly keeps the distance
  Bounded<Threat, most_neighbours> threats;
  Bounded<BarrierRow, most_half_spaces> rows;
  Bounded<BoundHeight, 2 + most_pieces> heights;
  Bounded<BoundPlane, 4 + most_pieces> planes;
};

}  // namespace sightline
