#include "sightline/base/polygon.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace sightline {
namespace {

constexpr double straight_turn = 1e-12;  // [m^2] a corner of a smaller turn counts as straight

Vec2<double> edge_between(const Vec2<double>& a, const Vec2<double>& b) { return {b.x - a.x, b.y - a.y}; }

/// Twice the area of the triangle a, b, c [m^2]; > 0: it is counterclockwise.
double turn_of(const Vec2<double>& a, const Vec2<double>& b, const Vec2<double>& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double distance_to_edge(const Vec2<double>& p, const Vec2<double>& a, const Vec2<double>& b) {
  const Vec2<double> d = edge_between(a, b), r = edge_between(a, p);
  const double length2 = dot(d, d), s = length2 > 0 ? std::clamp(dot(r, d) / length2, 0.0, 1.0) : 0.0;
  return norm(r.x - s * d.x, r.y - s * d.y);
}

/// Whether the edges from a to b and from c to d cross or come too near.
bool edges_meet(const Vec2<double>& a, const Vec2<double>& b, const Vec2<double>& c, const Vec2<double>& d) {
  const bool cross =
      (turn_of(a, b, c) > 0) != (turn_of(a, b, d) > 0) && (turn_of(c, d, a) > 0) != (turn_of(c, d, b) > 0);
  return cross || std::min({distance_to_edge(a, c, d), distance_to_edge(b, c, d), distance_to_edge(c, a, b),
                            distance_to_edge(d, a, b)}) < least_gap;
}

Polygon counterclockwise(Corners polygon) {
  Polygon turned(polygon.begin(), polygon.end());
  if (signed_area(turned) < 0) std::reverse(turned.begin(), turned.end());
  return turned;
}

/// Triangles of a counterclockwise polygon. Of all ears, that of the shortest diagonal is cut,
/// which avoids thin triangles.
std::vector<Polygon> ears_of(Polygon rest) {
  std::vector<Polygon> ears;
  while (rest.size() > 3) {
    const std::size_t n = rest.size();
    std::size_t ear = n, straightest = 0;
    double shortest = infinity, least_turn = infinity;
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2<double>&a = rest[(i + n - 1) % n], &b = rest[i], &c = rest[(i + 1) % n];
      const double turn = turn_of(a, b, c);
      if (std::abs(turn) < least_turn) least_turn = std::abs(turn), straightest = i;
      const Vec2<double> diagonal = edge_between(a, c);
      const double length2 = dot(diagonal, diagonal);
      if (turn <= straight_turn || length2 >= shortest) continue;
      const auto blocks = [&](const Vec2<double>& q) {
        return &q != &a && &q != &b && &q != &c && turn_of(a, b, q) >= 0 && turn_of(b, c, q) >= 0 &&
               turn_of(c, a, q) >= 0;
      };
      if (std::none_of(rest.begin(), rest.end(), blocks)) ear = i, shortest = length2;
    }
    // Without an ear, rounding has left a polygon without an area.
    const std::size_t cut = ear < n ? ear : straightest;
    if (ear < n) ears.push_back({rest[(cut + n - 1) % n], rest[cut], rest[(cut + 1) % n]});
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(cut));
  }
  if (turn_of(rest[0], rest[1], rest[2]) > 0) ears.push_back(std::move(rest));
  return ears;
}

bool is_convex(const Polygon& p) {
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (turn_of(p[i], p[(i + 1) % n], p[(i + 2) % n]) < -straight_turn) return false;
  }
  return true;
}

/// The union of two polygons across their common edge; empty without one, or if it is not convex.
Polygon merged(const Polygon& p, const Polygon& q) {
  const std::size_t n = p.size(), m = q.size();
  const auto same = [](const Vec2<double>& a, const Vec2<double>& b) { return a.x == b.x && a.y == b.y; };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < m; ++j) {
      if (!same(p[i], q[(j + 1) % m]) || !same(p[(i + 1) % n], q[j])) continue;
      Polygon both;
      for (std::size_t k = 1; k <= n; ++k) both.push_back(p[(i + k) % n]);
      for (std::size_t k = 2; k < m; ++k) both.push_back(q[(j + k) % m]);
      return is_convex(both) ? both : Polygon();
    }
  }
  return {};
}

/// Indices of the corners on the hull of a counterclockwise polygon, also of those amid its edges.
std::vector<std::size_t> corners_of_hull(const Polygon& p) {
  std::vector<std::size_t> order(p.size()), chain;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return std::pair(p[i].x, p[i].y) < std::pair(p[j].x, p[j].y);
  });
  std::vector<bool> on_hull(p.size());
  for (int side = 0; side < 2; ++side) {  // below, then above
    chain.clear();
    for (const std::size_t i : order) {
      while (chain.size() > 1 && turn_of(p[chain[chain.size() - 2]], p[chain.back()], p[i]) < -straight_turn)
        chain.pop_back();
      chain.push_back(i);
    }
    for (const std::size_t i : chain) on_hull[i] = true;
    std::reverse(order.begin(), order.end());
  }
  std::vector<std::size_t> corners;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (on_hull[i]) corners.push_back(i);
  }
  return corners;
}

}  // namespace

double signed_area(Corners polygon) noexcept {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += turn_of(polygon[0], polygon[i], polygon[(i + 1) % polygon.size()]);
  return 0.5 * twice;
}

std::string expected_of_corners(Corners corners) {
  const std::size_t n = corners.size();
  if (n < 3) return "at least 3 corners";
  const auto meeting = [](std::size_t i, std::size_t j) {
    return fmt::format("edges that neither cross nor touch (to {:g} m), edge {} meets edge {}", least_gap, i,
                       j);
  };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      const std::size_t after = (j + 1) % n;
      if (after != i && edges_meet(corners[i], corners[i + 1], corners[j], corners[after]))
        return meeting(i, j);
    }
  }
  if (std::abs(signed_area(corners)) < square(least_gap)) return "an area, its corners are on one line";
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = (i + n - 1) % n;
    const Vec2<double>&a = corners[before], &b = corners[i], &c = corners[(i + 1) % n];
    if (std::min(distance_to_edge(c, a, b), distance_to_edge(a, b, c)) < least_gap) return meeting(before, i);
  }
  return {};
}

double signed_distance(Corners polygon, const Vec2<double>& p) noexcept {
  double least = infinity;
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2<double>&a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    least = std::min(least, distance_to_edge(p, a, b));
    // A ray along x changes sides at each edge that it crosses.
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return inside ? -least : least;
}

std::vector<Polygon> convex_pieces(Corners polygon) {
  std::vector<Polygon> pieces = ears_of(counterclockwise(polygon));
  for (bool again = true; again;) {
    again = false;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      for (std::size_t j = i + 1; j < pieces.size();) {
        Polygon both = merged(pieces[i], pieces[j]);
        if (both.empty()) {
          ++j;
          continue;
        }
        pieces[i] = std::move(both);
        pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(j));
        again = true;
      }
    }
  }
  return pieces;
}

Polygon convex_hull(Corners polygon) {
  const Polygon p = counterclockwise(polygon);
  Polygon hull;
  for (const std::size_t i : corners_of_hull(p)) hull.push_back(p[i]);
  return hull;
}

std::vector<Polygon> pockets(Corners polygon) {
  const Polygon p = counterclockwise(polygon);
  const std::vector<std::size_t> hull = corners_of_hull(p);
  const std::size_t n = p.size();
  std::vector<Polygon> all;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const std::size_t from = hull[k], edges = (hull[(k + 1) % hull.size()] + n - from) % n;
    // The pocket is to the right of the polygon's corners, so that they come in reverse order.
    Polygon pocket;
    for (std::size_t i = edges + 1; i-- > 0;) pocket.push_back(p[(from + i) % n]);
    if (edges > 1 && signed_area(pocket) > straight_turn) all.push_back(std::move(pocket));
  }
  return all;
}

}  // namespace sightline
