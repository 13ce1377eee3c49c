/// Boundary of a limit between two bodies, as a surface of triangles for a page.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sightline/potential.hpp"

namespace sightline {

/// The surface between the places where a limit holds and those where it is broken.
///
/// It is computed on a grid of directions and ranges around the sensor or the second body. Each
/// grid edge whose ends differ gives a corner by bisection, within 1e-6 of the reach. Features
/// smaller than a cell may be missed.
struct LimitSurface {
  /// What the limit depends on; determines the frame of the surface.
  enum class Goes {
    with_sensor,  ///< on the second body in the frame S of the first one's sensor: corners are in S
    with_target,  ///< on the difference of both positions in G: corners are p_first - p_second, in G
    nowhere,      ///< on more than that: no fixed surface exists
  };

  Goes goes = Goes::nowhere;
  double reach = 0.0;   ///< range of the grid [m]; 1 for a surface that scales
  bool scales = false;  ///< the surface is a cone of rays from the origin; corners are within 1 m
  bool open = false;    ///< the surface continues beyond `reach`
  std::vector<Vec3<double>> corners{};
  std::vector<std::array<int, 3>> triangles{};  ///< indices of corners, of either orientation
  std::string lacks{};  ///< the part of the limit that is not drawn, a sentence; empty: none
};

/// Computes the surface of the limit that a potential states between two bodies.
/// @param mount  of the sensor, for Goes::with_sensor
/// @param rather  the frame to prefer if both are possible, as for a distance
/// @param farthest  range to which an open surface is drawn [m]
LimitSurface limit_surface(const Potential& potential, const SensorMount& mount,
                           LimitSurface::Goes rather = LimitSurface::Goes::with_sensor,
                           double farthest = 10.0);

}  // namespace sightline
