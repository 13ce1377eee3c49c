/// Simple polygons of the plane: area, distance, convex hull and convex pieces.
///
/// A polygon is the list of its corners in order; the last edge leads back to the first corner. The
/// orientation is free on input. Results are counterclockwise.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

using Polygon = std::vector<Vec2<double>>;
using Corners = std::span<const Vec2<double>>;

/// Least distance of an edge to all that it does not end at, in a valid polygon [m].
inline constexpr double least_gap = 1e-3;

/// [m^2], > 0 for counterclockwise corners.
double signed_area(Corners polygon) noexcept;

/// What was expected of corners that make no simple polygon, as "at least 3 corners"; empty if they
/// make one. The corners are finite.
std::string expected_of_corners(Corners corners);

/// Distance to the boundary [m], negative inside.
double signed_distance(Corners polygon, const Vec2<double>& p) noexcept;

/// Convex polygons that cover a simple polygon and have no area in common: its triangles by ear
/// clipping, merged across each diagonal that no convex piece needs (Hertel and Mehlhorn 1983).
/// Their number is at most four times the least possible.
std::vector<Polygon> convex_pieces(Corners polygon);

/// The convex hull of a simple polygon.
Polygon convex_hull(Corners polygon);
/// The simple polygons between a simple polygon and its hull.
std::vector<Polygon> pockets(Corners polygon);

}  // namespace sightline
