#include "sightline/safety/zone.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sightline/base/polygon.hpp"

namespace sightline {
namespace {

/// The face along an edge, with its normal to the right: out of a counterclockwise polygon.
Face face_along(const Vec2<double>& a, const Vec2<double>& b) {
  const double x = b.x - a.x, y = b.y - a.y, length = norm(x, y);
  const Vec2<double> n = {y / length, -x / length};
  return {n, dot(n, a)};
}

std::vector<Face> faces_of(const Polygon& convex) {
  std::vector<Face> faces;
  const std::size_t n = convex.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2<double>& corner = convex[(i + 1) % n];
    const Face before = face_along(convex[i], corner), after = face_along(corner, convex[(i + 2) % n]);
    faces.push_back(before);
    const Vec2<double> sum = {before.n.x + after.n.x, before.n.y + after.n.y};
    const double length = norm(sum.x, sum.y);
    constexpr double needle = 1e-6;
    if (dot(before.n, after.n) >= 0 || length < needle) continue;
    const Vec2<double> middle = {sum.x / length, sum.y / length};
    faces.push_back({middle, dot(middle, corner)});
  }
  return faces;
}

}  // namespace

double zone_reserve(const Zone& zone, const Vec3<double>& p) noexcept {
  const double aside = signed_distance(zone.polygon, {p.x, p.y}),
               above = std::max(zone.from - p.z, p.z - zone.to);
  const double beyond = aside > 0 && above > 0 ? norm(aside, above) : std::max(aside, above);
  return zone.keep == Zone::Keep::outside ? beyond : -beyond;
}

std::vector<Zone> zones_to_land(std::vector<Zone> zones) {
  for (Zone& zone : zones) {
    if (zone.keep == Zone::Keep::inside) zone.from = -infinity;
  }
  return zones;
}

std::vector<ForbiddenPiece> forbidden_pieces(const Zone& zone) {
  std::vector<ForbiddenPiece> pieces;
  if (zone.keep == Zone::Keep::outside) {
    for (const Polygon& convex : convex_pieces(zone.polygon))
      pieces.push_back({faces_of(convex), zone.from, zone.to});
    return pieces;
  }
  const Polygon hull = convex_hull(zone.polygon);
  for (std::size_t i = 0; i < hull.size(); ++i)
    pieces.push_back({.faces = {face_along(hull[(i + 1) % hull.size()], hull[i])}});
  for (const Polygon& pocket : pockets(zone.polygon)) {
    for (const Polygon& convex : convex_pieces(pocket)) pieces.push_back({.faces = faces_of(convex)});
  }
  if (zone.from > -infinity) pieces.push_back({.faces = {}, .high = zone.from});
  if (zone.to < infinity) pieces.push_back({.faces = {}, .low = zone.to});
  return pieces;
}

void validate(const Zone& zone) {
  if (const std::string expected = expected_of_corners(zone.polygon); !expected.empty())
    throw std::invalid_argument(fmt::format("barrier: the polygon of a zone has {} corners, expected {}",
                                            zone.polygon.size(), expected));
  if (!(zone.from < zone.to))
    throw std::invalid_argument(
        fmt::format("barrier: a zone from {} to {} m, expected from < to", zone.from, zone.to));
}

}  // namespace sightline
