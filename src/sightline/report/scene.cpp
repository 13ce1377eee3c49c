#include "sightline/report/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/report.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

constexpr double arrow_length = 0.4, mark_size = 0.15, line_width = 0.02, letter_height = 0.15,
                 name_above = 0.3;                    // [m]
constexpr double cone_least = 0.5, cone_most = 10.0;  // length of a drawn view [m]
constexpr int cone_sides = 16;

Colour colour_of(std::string_view hex, float alpha) {
  unsigned rgb = 0;
  std::from_chars(hex.data() + 1, hex.data() + hex.size(), rgb, 16);
  const auto part = [&](int shift) { return static_cast<float>((rgb >> shift) & 0xffU) / 255.0F; };
  return {part(16), part(8), part(0), alpha};
}

/// Cone of a view, from the sensor to `length`, with the half-angle of its limit.
std::vector<Vec3<double>> cone(const Observation& view, const Sight<double>& observer, double length) {
  const SensorMount& mount = view.mount;
  const Rotation B =
      rotation(mount.frame == MountFrame::body ? leaning(observer.d, observer.lean) : upright(observer.d));
  const Vec3<double> apex = observer.p + B.to_G(mount.offset);
  const Rotation S = compose(B, rotation_from(mount.attitude()));
  const double ahead = length * std::cos(view.alpha), aside = length * std::sin(view.alpha);
  const auto rim = [&](int k) {
    const double angle = 2 * std::numbers::pi * k / cone_sides;
    return apex + ahead * S.x + aside * (std::cos(angle) * S.y + std::sin(angle) * S.z);
  };
  std::vector<Vec3<double>> triangles;
  for (int k = 0; k < cone_sides; ++k) {
    triangles.push_back(apex);
    triangles.push_back(rim(k));
    triangles.push_back(rim((k + 1) % cone_sides));
  }
  return triangles;
}

/// The walls of a zone: two triangles for each edge of its polygon.
Drawn walls_of(const Zone& zone, int id) {
  const auto [low, high] = drawn_heights(zone);
  const bool forbidden = zone.keep == Zone::Keep::outside;
  Drawn walls = {.group = "zones",
                 .id = id,
                 .form = Drawn::triangles,
                 .colour = forbidden ? colour_of(palette_red, 0.25F) : colour_of(palette_grey, 0.12F)};
  for (std::size_t i = 0; i < zone.polygon.size(); ++i) {
    const Vec2<double>&a = zone.polygon[i], &b = zone.polygon[(i + 1) % zone.polygon.size()];
    walls.points.insert(walls.points.end(), {{a.x, a.y, low},
                                             {b.x, b.y, low},
                                             {b.x, b.y, high},
                                             {a.x, a.y, low},
                                             {b.x, b.y, high},
                                             {a.x, a.y, high}});
  }
  return walls;
}

std::vector<Scene::Pair> coupled_pairs(const Team& team) {
  std::vector<Scene::Pair> pairs;
  const auto known = [&](BodyId a, BodyId b) {
    return std::any_of(pairs.begin(), pairs.end(), [&](const Scene::Pair& pair) {
      return (pair.a == a && pair.b == b) || (pair.a == b && pair.b == a);
    });
  };
  for (const Observation& view : observations(team.couplings()))
    pairs.push_back({view.observer, view.target, view});
  for (const Coupling& coupling : team.couplings()) {
    const auto& [a, b] = coupling.between;
    if (!known(a, b)) pairs.push_back({a, b});
  }
  return pairs;
}

}  // namespace

std::pair<double, double> drawn_heights(const Zone& zone) noexcept {
  constexpr double height = 3.0;  // [m]
  const double low = std::isfinite(zone.from) ? zone.from : std::min(0.0, zone.to - height);
  return {low, std::isfinite(zone.to) ? zone.to : low + height};
}

Scene::Scene(const Scenario& scenario)
    : team_(scenario.team), pairs_(coupled_pairs(team_)), d_hard_(size(team_.bodies())) {
  for (const UncooperativeBody& one : scenario.uncooperative)
    d_hard_[size(one.body.index)] = hard_distance(scenario, BodyId{0}, one.body).value_or(0.0);
  if (!scenario.safety) return;
  for (const Zone& zone : scenario.safety->barrier_options.zones)
    zones_.push_back(walls_of(zone, static_cast<int>(zones_.size())));
}

void Scene::draw_body(std::vector<Drawn>& all, int body, const Sight<double>& seen) const {
  const bool robot = team_.is_agent(BodyId{body});
  const std::string_view hex = robot ? palette[size(body) % palette_robots] : palette_grey;
  Drawn mark = {
      .group = robot ? "robots" : "bodies", .id = body, .colour = colour_of(hex, 1.0F), .p = seen.p};
  mark.size = {mark_size, mark_size, mark_size};
  if (robot) {
    mark.form = Drawn::arrow;
    mark.q = leaning(seen.d, seen.lean);
    mark.size = {arrow_length, mark_size / 2, mark_size / 2};
  }
  all.push_back(mark);
  if (const double d = d_hard_[size(body)]; d > 0)
    all.push_back({.group = "hard_distances",
                   .id = body,
                   .colour = colour_of(palette_grey, 0.2F),
                   .p = seen.p,
                   .size = {2 * d, 2 * d, 2 * d}});
  all.push_back({.group = "names",
                 .id = body,
                 .form = Drawn::text,
                 .colour = colour_of(hex, 1.0F),
                 .p = seen.p + Vec3<double>{0, 0, name_above},
                 .size = {0, 0, letter_height},
                 .words = std::string(team_.name(BodyId{body}))});
}

void Scene::draw_pair(std::vector<Drawn>& all, int id, const Pair& pair, const Sight<double>& a,
                      const Sight<double>& b, double t) const {
  const double distance = norm(a.p - b.p);
  std::string_view hex = palette_grey;
  if (pair.view) {
    hex = is_in_view(*pair.view, a, b, t) ? palette_green : palette_red;
    if (std::isfinite(pair.view->alpha))
      all.push_back({.group = "views",
                     .id = id,
                     .form = Drawn::triangles,
                     .colour = colour_of(hex, 0.25F),
                     .points = cone(*pair.view, a, std::clamp(distance, cone_least, cone_most))});
  }
  all.push_back({.group = "links",
                 .id = id,
                 .form = Drawn::line,
                 .colour = colour_of(hex, 1.0F),
                 .size = {line_width, 0, 0},
                 .points = {a.p, b.p}});
  all.push_back({.group = "distances",
                 .id = id,
                 .form = Drawn::text,
                 .colour = colour_of(hex, 1.0F),
                 .p = 0.5 * (a.p + b.p),
                 .size = {0, 0, letter_height},
                 .words = fmt::format("{:.2f} m", distance)});
}

std::vector<Drawn> Scene::draw(std::span<const std::optional<Sight<double>>> bodies, double t) const {
  std::vector<Drawn> all = zones_;
  for (int i = 0; i < team_.bodies(); ++i)
    if (const auto& seen = bodies[size(i)]) draw_body(all, i, *seen);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto &a = bodies[size(pairs_[k].a.index)], &b = bodies[size(pairs_[k].b.index)];
    if (!a || !b) continue;
    const auto sight = [&](BodyId body) { return bodies[size(body.index)].value_or(Sight<double>{}); };
    const BodyId third = pairs_[k].view ? pairs_[k].view->third : BodyId{};
    draw_pair(all, static_cast<int>(k), pairs_[k], first_sight(sight, pairs_[k].a, third), *b, t);
  }
  return all;
}

}  // namespace sightline
