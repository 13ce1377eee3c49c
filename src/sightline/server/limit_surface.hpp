/// Where a limit between two bodies is just kept, as a surface of triangles that a page can draw.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sightline/potential/potential.hpp"

namespace sightline {

/// The surface between where a limit holds and where it is broken.
///
/// It is found on a grid of directions and ranges around the sensor, or around the second body: a corner for each edge of the grid whose
/// ends differ, by bisection, so corners lie on the surface to 1e-6 of the reach, and what is smaller than a cell may be missed.
struct LimitSurface {
  /// What the limit depends on, which says where the surface goes.
  enum class Goes {
    with_sensor,  ///< the place of the second body in the frame S of the first one's sensor: corners are in S
    with_target,  ///< the difference of both places in G: corners are where the first body is, seen from the second, in G
    nowhere,  ///< more than that: there is no surface that stays
  };

  Goes goes = Goes::nowhere;
  double reach = 0.0;   ///< of the corners [m], without those of a surface that scales
  bool scales = false;  ///< it looks alike from near and from far; corners are at 1 m
  bool open = false;    ///< it goes on beyond `reach`
  std::vector<Vec3<double>> corners{};
  std::vector<std::array<int, 3>> triangles{};  ///< either way round
  std::string lacks{};  ///< what of the limit is not drawn, a sentence; empty: nothing
};

/// Looks at the limit that a potential states between two bodies.
/// @param mount  of the sensor; of a limit that goes with it
/// @param rather  what it goes with where it could go with both, as a distance does
/// @param farthest  a surface that goes on is drawn up to there [m]
LimitSurface limit_surface(const Potential& potential, const SensorMount& mount,
                           LimitSurface::Goes rather = LimitSurface::Goes::with_sensor,
                           double farthest = 10.0);

}  // namespace sightline
