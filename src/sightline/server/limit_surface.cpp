#include "sightline/server/limit_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <unordered_map>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr double pi = std::numbers::pi;

/// Whether the limit holds at a relative position: of the second body in S, or of the first in G.
using Holds = std::function<bool(const Vec3<double>&)>;

/// Sensor frame S of a robot: p_S = origin + R (p - at), with the columns x, y, z of R.
struct SensorFrame {
  Vec3<double> at, origin, x, y, z;

  SensorFrame(const SensorMount& mount, const Sight<double>& robot)
      : at(robot.p),
        origin(mount(robot, at)),
        x(mount(robot, at + Vec3<double>{1, 0, 0}) - origin),
        y(mount(robot, at + Vec3<double>{0, 1, 0}) - origin),
        z(mount(robot, at + Vec3<double>{0, 0, 1}) - origin) {}

  /// Position in G of a point in S.
  Vec3<double> point(const Vec3<double>& p_S) const {
    const Vec3<double> r = p_S - origin;
    const auto along = [&](const Vec3<double>& axis) { return axis.x * r.x + axis.y * r.y + axis.z * r.z; };
    return at + Vec3<double>{along(x), along(y), along(z)};
  }
};

Sight<double> upright_at(const Vec3<double>& p) {
  Sight<double> s{};
  s.p = p, s.d = {1, 0};
  return s;
}

/// Random values of all that a limit may depend on besides the relative position.
class LimitDraws {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec3<double> within(double size) {
    return {between(-size, size), between(-size, size), between(-size, size)};
  }
  Sight<double> sight() {
    const double psi = between(-pi, pi);
    Sight<double> s{};
    s.p = within(20.0), s.d = {std::cos(psi), std::sin(psi)}, s.v = within(2.0);
    s.lean = {between(-0.3, 0.3), between(-0.3, 0.3)};
    return s;
  }
  /// A position at a log-uniform scale, 0.1 to 20 m.
  Vec3<double> place() {
    const double far = std::pow(10.0, between(-1.0, 1.3));
    return far * within(1.0);
  }

 private:
  std::mt19937_64 random_{1};
};

bool alike(double a, double b) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) == std::isnan(b);
  return a == b || std::fabs(a - b) <= 1e-6 * (1 + std::fabs(a));
}

LimitSurface::Goes what_it_goes_with(const Potential& potential, const SensorMount& mount,
                                     LimitSurface::Goes rather) {
  constexpr int draws = 200;
  const auto unchanged = [&](const auto& both, const auto& plain) {
    LimitDraws drawn;
    for (int i = 0; i < draws; ++i) {
      const Vec3<double> place = drawn.place();
      const auto [a, b] = both(drawn, place);
      const auto [a0, b0] = plain(place);
      if (!alike(potential.violation(a, b, drawn.between(0, 100)), potential.violation(a0, b0, 0.0)))
        return false;
    }
    return true;
  };
  using Two = std::pair<Sight<double>, Sight<double>>;
  const auto with_sensor = [&] {
    return unchanged(
        [&](LimitDraws& drawn, const Vec3<double>& p_S) {
          const Sight<double> a = drawn.sight();
          Sight<double> b = drawn.sight();
          b.p = SensorFrame(mount, a).point(p_S);
          return Two(a, b);
        },
        [&](const Vec3<double>& p_S) {
          const Sight<double> a = upright_at({});
          return Two(a, upright_at(SensorFrame(mount, a).point(p_S)));
        });
  };
  const auto with_target = [&] {
    return unchanged(
        [&](LimitDraws& drawn, const Vec3<double>& r) {
          Sight<double> a = drawn.sight();
          const Sight<double> b = drawn.sight();
          a.p = b.p + r;
          return Two(a, b);
        },
        [&](const Vec3<double>& r) { return Two(upright_at(r), upright_at({})); });
  };
  using Goes = LimitSurface::Goes;
  if (rather == Goes::with_target && with_target()) return Goes::with_target;
  if (with_sensor()) return Goes::with_sensor;
  return with_target() ? Goes::with_target : Goes::nowhere;
}

/// Grid of directions by their angle from the axis x, finer near it, and around it; ranges from 0.
class Grid {
 public:
  static constexpr int rings = 32, sides = 64;

  Grid(double reach, int shells) : reach_(reach), shells_(shells) {}

  int shells() const { return shells_; }
  /// Coincident nodes have one number.
  std::int64_t node(int ring, int side, int shell) const {
    if (shell == 0) return 0;
    if (ring == 0 || ring == rings) side = 0;
    return 1 + side % sides + sides * (ring + static_cast<std::int64_t>(rings + 1) * shell);
  }
  Vec3<double> place(int ring, int side, int shell) const {
    return (reach_ * shell / shells_) * direction(ring, side);
  }
  static Vec3<double> direction(int ring, int side) {
    const double share = static_cast<double>(ring) / rings;
    const double theta = pi * share * (0.3 + 0.7 * share), phi = 2 * pi * side / sides;
    return {std::cos(theta), std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi)};
  }

 private:
  double reach_;
  int shells_;
};

/// Extracts the surface from a grid by marching tetrahedra.
class Marching {
 public:
  Marching(const Grid& grid, const Holds& holds, LimitSurface& to) : grid_(grid), holds_(holds), to_(to) {}

  void through_all_cells() {
    for (int shell = 0; shell < grid_.shells(); ++shell)
      for (int ring = 0; ring < Grid::rings; ++ring)
        for (int side = 0; side < Grid::sides; ++side) cell(ring, side, shell);
  }

 private:
  struct Node {
    std::int64_t number;
    Vec3<double> place;
    bool inside;
  };

  Node node(int ring, int side, int shell) {
    const std::int64_t number = grid_.node(ring, side, shell);
    const Vec3<double> place = grid_.place(ring, side, shell);
    const auto [known, is_new] = inside_.try_emplace(number, false);
    if (is_new) known->second = holds_(place);
    return {number, place, known->second};
  }

  void cell(int ring, int side, int shell) {
    std::array<Node, 8> n;
    for (unsigned i = 0; i < 8; ++i)
      n[i] = node(ring + static_cast<int>(i & 1U), side + static_cast<int>(i >> 1U & 1U),
                  shell + static_cast<int>(i >> 2U & 1U));
    if (std::all_of(n.begin(), n.end(), [&](const Node& one) { return one.inside == n[0].inside; })) return;
    // Six tetrahedra around the diagonal from 0 to 7, one for each order of the three axes.
    constexpr std::array<std::array<unsigned, 2>, 6> ways = {
        {{1, 3}, {1, 5}, {2, 3}, {2, 6}, {4, 5}, {4, 6}}};
    for (const auto& [first, second] : ways) tetrahedron({n[0], n[first], n[second], n[7]});
  }

  void tetrahedron(std::array<Node, 4> n) {
    // Nodes inside come first.
    std::stable_partition(n.begin(), n.end(), [](const Node& one) { return one.inside; });
    switch (std::count_if(n.begin(), n.end(), [](const Node& one) { return one.inside; })) {
      case 1:
        triangle(corner(n[0], n[1]), corner(n[0], n[2]), corner(n[0], n[3]));
        break;
      case 2: {
        const int a = corner(n[0], n[2]), b = corner(n[0], n[3]);
        const int c = corner(n[1], n[3]), d = corner(n[1], n[2]);
        triangle(a, b, c);
        triangle(a, c, d);
        break;
      }
      case 3:
        triangle(corner(n[0], n[3]), corner(n[1], n[3]), corner(n[2], n[3]));
        break;
      default:
        break;
    }
  }

  int corner(const Node& inside, const Node& outside) {
    const std::uint64_t low = static_cast<std::uint64_t>(std::min(inside.number, outside.number));
    const std::uint64_t key =
        low << 32U | static_cast<std::uint64_t>(std::max(inside.number, outside.number));
    const auto [known, is_new] = corners_.try_emplace(key, static_cast<int>(to_.corners.size()));
    if (!is_new) return known->second;
    Vec3<double> kept = inside.place, broken = outside.place;
    for (int i = 0; i < 20; ++i) {
      const Vec3<double> middle = 0.5 * (kept + broken);
      (holds_(middle) ? kept : broken) = middle;
    }
    to_.corners.push_back(kept);
    return known->second;
  }

  /// Omits degenerate triangles.
  void triangle(int a, int b, int c) {
    if (a == b || b == c || c == a) return;
    const auto at = [&](int i) { return to_.corners[size(i)]; };
    const Vec3<double> u = at(b) - at(a), v = at(c) - at(a);
    const double area =
        norm(Vec3<double>{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x});
    if (area > 1e-9 * square(to_.reach)) to_.triangles.push_back({a, b, c});
  }

  const Grid& grid_;
  const Holds& holds_;
  LimitSurface& to_;
  std::unordered_map<std::int64_t, bool> inside_;
  std::unordered_map<std::uint64_t, int> corners_;
};

/// Range of the places where the limit holds, over fewer directions than in the grid.
struct Extent {
  double last = 0.0, beyond = 0.0;  ///< largest range at which it holds, and the next one [m]
  bool anywhere = false, forever = false, scales = true;
};

Extent extent_of(const Holds& holds) {
  constexpr double nearest = 0.05, ratio = 1.25;
  constexpr int ranges = 45;  // up to 900 m
  Extent e;
  for (int ring = 0; ring <= Grid::rings; ++ring) {
    for (int side = 0; side < Grid::sides; side += 2) {
      const Vec3<double> direction = Grid::direction(ring, side);
      const bool first = holds(nearest * direction);
      double range = nearest;
      for (int k = 0; k < ranges; ++k, range *= ratio) {
        const bool here = holds(range * direction);
        e.scales = e.scales && here == first;
        e.anywhere = e.anywhere || here;
        if (here && range > e.last) e.last = range, e.beyond = ratio * range;
        if (here && k + 1 == ranges) e.forever = true;
      }
    }
  }
  return e;
}

void drop_unused_corners(LimitSurface& surface) {
  std::vector<int> now(surface.corners.size(), -1);
  std::vector<Vec3<double>> kept;
  for (auto& triangle : surface.triangles) {
    for (int& corner : triangle) {
      int& place = now[size(corner)];
      if (place < 0) {
        place = static_cast<int>(kept.size());
        kept.push_back(surface.corners[size(corner)]);
      }
      corner = place;
    }
  }
  surface.corners = std::move(kept);
}

void draw(LimitSurface& surface, const Holds& holds, double farthest) {
  const Extent inside = extent_of(holds);
  // The inside and the outside have the same surface: the bounded one gives the range of the grid.
  const Holds broken = [&](const Vec3<double>& p) { return !holds(p); };
  const Extent extent = inside.forever ? extent_of(broken) : inside;
  surface.scales = inside.scales;
  surface.open = extent.forever && !inside.scales;
  surface.reach = inside.scales ? 1.0 : extent.forever ? farthest : extent.beyond;
  if (!inside.anywhere || !extent.anywhere) {
    surface.lacks =
        inside.anywhere ? "its limit holds everywhere" : "no place was found where its limit holds";
    return;
  }
  Marching(Grid(surface.reach, inside.scales ? 1 : 12), holds, surface).through_all_cells();
  drop_unused_corners(surface);
  if (surface.triangles.empty())
    surface.lacks = fmt::format("nothing of its limit is within {} m", surface.reach);
}

}  // namespace

LimitSurface limit_surface(const Potential& potential, const SensorMount& mount, LimitSurface::Goes rather,
                           double farthest) {
  std::vector<Potential> drawn = {potential};
  LimitSurface surface;
  surface.goes = what_it_goes_with(potential, mount, rather);
  if (surface.goes == LimitSurface::Goes::nowhere) {
    // Some of a conjunction's limits may still have a fixed surface.
    const std::vector<Potential> all = potential.conjuncts();
    drawn.clear();
    for (const Potential& one : all)
      if (what_it_goes_with(one, mount, LimitSurface::Goes::with_sensor) == LimitSurface::Goes::with_sensor)
        drawn.push_back(one);
    const std::string what = "depends on more than where one body is to the other";
    if (drawn.empty()) {
      surface.lacks = "its limit " + what;
      return surface;
    }
    surface.goes = LimitSurface::Goes::with_sensor;
    surface.lacks = fmt::format("{} of its {} limits {}", all.size() - drawn.size(), all.size(), what);
  }
  const bool with_sensor = surface.goes == LimitSurface::Goes::with_sensor;
  const SensorFrame frame(mount, upright_at({}));
  const Holds holds = [&](const Vec3<double>& p) {
    const Sight<double> a = upright_at(with_sensor ? Vec3<double>{} : p);
    const Sight<double> b = upright_at(with_sensor ? frame.point(p) : Vec3<double>{});
    return std::all_of(drawn.begin(), drawn.end(),
                       [&](const Potential& one) { return one.violation(a, b, 0.0) <= 0; });
  };
  const std::string partly = surface.lacks;
  draw(surface, holds, farthest);
  if (!partly.empty() && !surface.lacks.empty()) surface.lacks = partly + "; " + surface.lacks;
  if (surface.lacks.empty()) surface.lacks = partly;
  return surface;
}

}  // namespace sightline
