#include "sightline/report/flown_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/judge/planned_view.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/report/page.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Panel = Drawing::Panel;

double tilt_of(const Vec2<double>& lean) { return std::atan(norm(lean.x, lean.y)); }

/// The row of the period at a time; none if the recording lacks it.
std::optional<std::size_t> row_at(const Recording& r, double time) {
  const auto found = std::lower_bound(r.time.begin(), r.time.end(), time - same_time);
  if (found == r.time.end() || (r.stride > 1 && *found > time + same_time)) return std::nullopt;
  return static_cast<std::size_t>(found - r.time.begin());
}

/// Distance of a body from its reference, at each logged reference.
std::vector<double> errors_of(const Recording& r, const Recording::Body& body) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < body.reference_p.size(); ++i) {
    const auto row = row_at(r, body.reference_time[i]);
    errors.push_back(row ? norm(body.p[*row] - body.reference_p[i]) : no_value);
  }
  return errors;
}

}  // namespace

PlannedAngles planned_angles(const Recording& r, const Recording::Pair& pair) {
  const Recording::Body &observer = r.bodies.at(pair.observer), &target = r.bodies.at(pair.target);
  PlannedAngles planned;
  if (!observer.leans) return planned;
  std::size_t of_target = 0;
  for (std::size_t i = 0; i < observer.planned.size(); ++i) {
    const double then = observer.planned_time[i];
    // A target that is no robot keeps its velocity.
    std::optional<Vec3<double>> p;
    while (of_target < target.planned.size() && target.planned_time[of_target] < then - same_time)
      ++of_target;
    if (of_target < target.planned.size() && target.planned_time[of_target] < then + same_time)
      p = target.planned[of_target].p;
    if (const auto row = row_at(r, then - PlannedAhead::ahead); !target.is_agent && row)
      p = target.p[*row] + PlannedAhead::ahead * target.v[*row];
    if (!p) continue;
    planned.time.push_back(then);
    planned.angle.push_back(view_angle(pair.mount, observer.planned[i], *p));
  }
  return planned;
}

std::optional<Drawing> flown_drawing(const Recording& r, const Curves& curves,
                                     const std::vector<std::size_t>& bodies) {
  Panel tilt{.x_label = "", .y_label = "tilt [rad]", .height = 160},
      error{.x_label = "t [s]", .y_label = "|p − p*| [m]"};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Recording::Body& body = r.bodies.at(bodies[i]);
    if (!body.leans) continue;
    std::vector<double> flown, planned;
    for (const Vec2<double>& lean : body.lean) flown.push_back(tilt_of(lean));
    for (const Sight<double>& sight : body.planned) planned.push_back(tilt_of(sight.lean));
    tilt.curves.push_back(curves.over_time(label(body.name), i, Mark::line, flown));
    tilt.curves.push_back(curves.curve("", i, Mark::dashed, body.planned_time, planned));
    if (!body.reference_p.empty())
      error.curves.push_back(
          curves.curve(label(body.name), i, Mark::line, body.reference_time, errors_of(r, body)));
  }
  if (tilt.curves.empty()) return std::nullopt;
  Drawing drawing{
      "Tilt, planned and flown",
      fmt::format("Of the body's axis; dashed: as it was planned {} s before", PlannedAhead::ahead),
      {}};
  drawing.panels.push_back(std::move(tilt));
  if (!error.curves.empty()) {
    drawing.title = "Tilt and tracking, planned and flown";
    drawing.caption += ". Below: distance from the reference";
    drawing.panels.push_back(std::move(error));
  }
  drawing.caption += ".";
  drawing.panels.back().x_label = "t [s]";
  return drawing;
}

std::string flown_table(std::string_view summary) {
  const auto rows = planned_rows(summary);
  if (rows.empty()) return "";
  std::string table = fmt::format(
      "<h2>Planned and flown</h2>\n<table>\n<tr class=\"soft\"><td></td><td>planned {} s before</td>"
      "<td>flown</td><td>difference, RMS</td></tr>\n",
      PlannedAhead::ahead);
  for (const auto& [what, planned, flown, difference] : rows) {
    table += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                         escaped(what), escaped(planned), escaped(flown), escaped(difference));
  }
  return table + "</table>\n";
}

}  // namespace sightline
