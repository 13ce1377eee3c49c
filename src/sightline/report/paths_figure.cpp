#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/report/run_figures.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Curve = Drawing::Curve;
using Panel = Drawing::Panel;

constexpr double mark_interval = 1.67;   // between two marked positions of Fig. 20 [s]
constexpr std::size_t places_max = 600;  // points of a line
constexpr std::size_t names_max = 32;    // names beside the paths
constexpr std::size_t side_names_max = 12;
constexpr std::size_t observers_max = 32;  // most observers with heading and cone
constexpr double footprint_max = 2.0;      // without a d_max [m]

/// The extent of one coordinate of all paths.
struct Extent {
  double low = no_value, high = no_value;

  explicit Extent(const Recording& r, double Vec3<double>::*axis) {
    for (const Recording::Body& body : r.bodies) {
      for (const Vec3<double>& p : body.p) low = std::fmin(low, p.*axis), high = std::fmax(high, p.*axis);
    }
  }
  double length() const { return high - low; }
};

/// One past the last known point of a path.
std::size_t last_of(const Recording::Body& body) {
  std::size_t k = body.p.size();
  while (k > 0 && !std::isfinite(body.p[k - 1].x)) --k;
  return k;
}

/// Footprint of a cone with half-angle alpha and pitch beta: a sector about its yaw of half-angle
/// asin(sin alpha / cos beta), or the full circle if the cone contains the vertical. Assumes an
/// upright robot.
Curve footprint(const Recording& r, const Recording::Pair& pair) {
  const Recording::Body& body = r.bodies[pair.observer];
  Curve edge{"", pair.observer % Drawing::colours, Mark::dashed, {}, {}};
  const std::size_t end = std::min(last_of(body), body.heading.size());
  if (end == 0 || !std::isfinite(pair.alpha)) return edge;
  const double ahead = body.heading[end - 1], psi = ahead + pair.mount.yaw,
               reach = std::isfinite(pair.d_max) ? pair.d_max : footprint_max;
  const double beta = std::abs(pair.mount.pitch), pi = std::numbers::pi;
  const double half = pair.alpha + beta < pi / 2 ? std::asin(std::sin(pair.alpha) / std::cos(beta)) : pi;
  const Vec2<double> arm =
      rotate<double>({std::cos(ahead), std::sin(ahead)}, {pair.mount.offset.x, pair.mount.offset.y});
  const double x = body.p[end - 1].x + arm.x, y = body.p[end - 1].y + arm.y;
  const auto corner = [&](double angle, double length) {
    edge.x.push_back(x + length * std::cos(psi + angle));
    edge.y.push_back(y + length * std::sin(psi + angle));
  };
  constexpr int arc = 16;
  corner(0, 0);
  for (int i = 0; i <= arc; ++i) corner(half * (2.0 * i / arc - 1), reach);
  corner(0, 0);
  return edge;
}

}  // namespace

Drawing paths_drawing(const Recording& r, const Curves& curves) {
  const Extent of_x(r, &Vec3<double>::x), of_y(r, &Vec3<double>::y);
  const bool along_x = !(of_y.length() > of_x.length());
  Panel above{.x_label = "x [m]", .y_label = "y [m]", .height = 620, .equal_scales = true};
  Panel side{.x_label = along_x ? "x [m]" : "y [m]", .y_label = "z [m]", .height = 220};
  side.title = along_x ? "From the side, along y" : "From the side, along x";
  above.title = "From above";
  const bool by_colour = r.bodies.size() <= Drawing::colours,
             by_name = !by_colour && r.bodies.size() <= names_max;
  Curve starts{"start", Drawing::faint_colour, Mark::points, {}, {}},
      begun{"", Drawing::faint_colour, Mark::points, {}, {}};
  for (std::size_t i = 0; i < r.bodies.size(); ++i) {
    const Recording::Body& body = r.bodies[i];
    const auto x = along(body.p, &Vec3<double>::x), y = along(body.p, &Vec3<double>::y),
               z = along(body.p, &Vec3<double>::z);
    const auto& across = along_x ? x : y;
    const auto first = static_cast<std::size_t>(
        std::find_if(x.begin(), x.end(), [](double v) { return std::isfinite(v); }) - x.begin());
    if (first == x.size()) continue;
    starts.x.push_back(x[first]), starts.y.push_back(y[first]);
    begun.x.push_back(across[first]), begun.y.push_back(z[first]);
    const std::size_t colour = i % Drawing::colours;
    above.curves.push_back(curves.curve(by_colour ? label(body.name) : "", colour, Mark::line, x, y));
    side.curves.push_back(curves.curve("", colour, Mark::line, across, z));
    if (by_name) {
      const std::size_t end = last_of(body) - 1;
      above.labels.push_back({x[end], y[end], label(body.name, 10)});
      if (r.bodies.size() <= side_names_max)
        side.labels.push_back({across[end], z[end], label(body.name, 10)});
    }
  }
  const double arrow = std::max(0.05, 0.05 * std::max(of_x.length(), of_y.length()));
  const std::size_t stride = std::max(
      {std::size_t{1}, static_cast<std::size_t>(std::lround(mark_interval / std::max(r.row_time(), 1e-4))),
       r.time.size() / places_max});
  Curve joined{"at the same time", Drawing::faint_colour, Mark::thin, {}, {}};
  std::set<std::size_t> observers;
  bool cones = false;
  for (const Recording::Pair& pair : r.pairs) {
    if (observers.size() == observers_max) break;
    const bool is_new = observers.insert(pair.observer).second;
    const auto &from = r.bodies.at(pair.observer).p, &to = r.bodies.at(pair.target).p;
    for (std::size_t k = 0; k < std::min(from.size(), to.size()); k += stride) {
      joined.x.insert(joined.x.end(), {from[k].x, to[k].x, no_value});
      joined.y.insert(joined.y.end(), {from[k].y, to[k].y, no_value});
    }
    Curve cone = footprint(r, pair);
    if (cone.x.empty() || !is_new) continue;
    if (!std::exchange(cones, true) && by_colour) cone.title = "seen at the end";
    above.curves.push_back(std::move(cone));
  }
  for (std::size_t i = 0; i < r.bodies.size() && r.pairs.empty() && observers.size() < observers_max; ++i) {
    if (r.bodies[i].is_agent) observers.insert(i);
  }
  for (const std::size_t i : observers) {
    const Recording::Body& body = r.bodies[i];
    Curve headings{"", i % Drawing::colours, Mark::arrows, {}, {}};
    for (std::size_t k = 0; k < std::min(body.p.size(), body.heading.size()); k += stride) {
      headings.x.insert(headings.x.end(), {body.p[k].x, body.p[k].x + arrow * std::cos(body.heading[k])});
      headings.y.insert(headings.y.end(), {body.p[k].y, body.p[k].y + arrow * std::sin(body.heading[k])});
    }
    above.curves.push_back(std::move(headings));
  }
  above.curves.insert(above.curves.begin(), std::move(joined));
  for (const std::vector<Vec2<double>>& polygon : r.zones) {
    const bool is_first = &polygon == &r.zones.front();
    Curve edges{is_first ? "zones" : "", Drawing::limit_colour, Mark::dashed, {}, {}};
    for (std::size_t k = 0; k <= polygon.size() && !polygon.empty(); ++k) {
      edges.x.push_back(polygon[k % polygon.size()].x);
      edges.y.push_back(polygon[k % polygon.size()].y);
    }
    above.curves.push_back(std::move(edges));
  }
  above.curves.push_back(std::move(starts));
  side.curves.push_back(std::move(begun));
  if (const Extent& extent = along_x ? of_x : of_y; std::isfinite(r.floor) && extent.length() > 0) {
    side.curves.push_back({fmt::format("floor {:.4g} m", r.floor),
                           Drawing::limit_colour,
                           Mark::dashed,
                           {extent.low, extent.high},
                           {r.floor, r.floor}});
  }
  std::string caption =
      fmt::format("Arrows: headings of {}, each {:.4g} s", r.pairs.empty() ? "the robots" : "the observers",
                  static_cast<double>(stride) * r.row_time());
  if (!r.pairs.empty()) caption += "; grey: observer and target at the same time";
  if (cones) caption += "; dashed: what the sensor covers at the end";
  if (by_name) caption += "; names stand at the ends of the paths";
  return {"Paths", caption + ".", {std::move(above), std::move(side)}};
}

}  // namespace sightline
