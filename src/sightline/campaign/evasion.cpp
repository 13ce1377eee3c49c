#include "sightline/campaign/evasion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/report/curves.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Curve = Drawing::Curve;
using Panel = Drawing::Panel;
using CurveColumn = std::vector<double>;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double row_time = 0.1;         // [s]
constexpr double apart = 4.2;            // interval between the marked positions of Fig. 26 [s]
constexpr double arrow = 0.25;           // length of a heading's arrow [m]
constexpr std::size_t rows_shown = 240;  // per curve
constexpr std::size_t robot_colour = 0, target_colour = 2;

BodyId body_of(const Team& team, std::string_view name) {
  const BodyId body = team.find(name);
  if (body.index < 0) {
    throw std::invalid_argument(
        fmt::format("evasion: \"{}\" is not in the scenario, expected a body of it", name));
  }
  return body;
}

SensorMount mount_of(const Team& team, BodyId agent, BodyId target) {
  for (const Observation& pair : observations(team.couplings())) {
    if (pair.observer == agent && pair.target == target) return pair.mount;
  }
  throw std::invalid_argument(fmt::format("evasion: no coupling by which \"{}\" sees \"{}\", expected one",
                                          team.name(agent), team.name(target)));
}

using Axis = double Vec3<double>::*;

/// Unwraps an angle over time, to avoid lines from pi to -pi.
CurveColumn with_gaps(CurveColumn angle) {
  for (std::size_t i = angle.size(); i-- > 1;) {
    if (std::fabs(angle[i] - angle[i - 1]) > std::numbers::pi) angle[i] = no_value;
  }
  return angle;
}

/// The rows from a time on.
CurveColumn since(double from, const CurveColumn& time, CurveColumn values) {
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = time[k] < from ? no_value : values[k];
  return values;
}

/// One curve for each run, and horizontal limits.
template <class Get>
Panel panel_of(const EvasionRuns& flown, std::string y_label, const CurveColumn& limits, Get&& get) {
  Panel panel{.x_label = "", .y_label = std::move(y_label)};
  double end = 0.0;
  for (std::size_t i = 0; i < flown.runs.size(); ++i) {
    const EvasionSeries& series = flown.runs[i].series();
    const CurveColumn y = get(series);
    panel.curves.push_back(thinned("", i % Drawing::colours, Mark::thin, series.time, y, rows_shown));
    if (!series.time.empty()) end = std::max(end, series.time.back());
  }
  for (const double limit : limits)
    panel.curves.push_back({"", Drawing::limit_colour, Mark::dashed, {0.0, end}, {limit, limit}});
  return panel;
}

Drawing over_time(std::string title, std::string caption, std::vector<Panel> panels) {
  panels.back().x_label = "t [s]";
  return {std::move(title), std::move(caption), std::move(panels)};
}

/// Paths from above, and every 4.2 s the robot with its heading and lines to target and obstacle.
Panel paths_panel(const EvasionTrace& run, std::size_t number, double from) {
  const EvasionSeries& s = run.series();
  Panel panel{.x_label = "x [m]",
              .y_label = "y [m]",
              .height = 260,
              .equal_scales = true,
              .title = fmt::format("run {}", number)};
  const auto line = [](std::size_t colour, Mark mark) { return Curve{"", colour, mark, {}, {}}; };
  Curve robot = line(robot_colour, Mark::line), obstacle = line(Drawing::limit_colour, Mark::dashed);
  Curve sight = line(Drawing::faint_colour, Mark::thin), gap = line(Drawing::limit_colour, Mark::thin);
  Curve headings = line(robot_colour, Mark::arrows), places = line(Drawing::limit_colour, Mark::points);
  Curve targets = line(target_colour, Mark::points);
  const auto stride = static_cast<std::size_t>(std::lround(apart / row_time));
  for (std::size_t k = 0; k < s.time.size(); ++k) {
    const Vec3<double>&p = s.p[k], &o = s.obstacle[k], &t = s.target[k];
    const bool there = s.time[k] >= from;
    robot.x.push_back(p.x), robot.y.push_back(p.y);
    if (there) obstacle.x.push_back(o.x), obstacle.y.push_back(o.y);
    if (k % stride != 0) continue;
    sight.x.insert(sight.x.end(), {p.x, t.x, no_value});
    sight.y.insert(sight.y.end(), {p.y, t.y, no_value});
    headings.x.insert(headings.x.end(), {p.x, p.x + arrow * std::cos(s.heading[k])});
    headings.y.insert(headings.y.end(), {p.y, p.y + arrow * std::sin(s.heading[k])});
    targets.x.push_back(t.x), targets.y.push_back(t.y);
    if (!there) continue;
    gap.x.insert(gap.x.end(), {p.x, o.x, no_value});
    gap.y.insert(gap.y.end(), {p.y, o.y, no_value});
    places.x.push_back(o.x), places.y.push_back(o.y);
  }
  panel.curves = {std::move(sight),    std::move(gap),    std::move(obstacle), std::move(robot),
                  std::move(headings), std::move(places), std::move(targets)};
  return panel;
}

struct Quantity {
  std::string_view name;
  std::vector<double> EvasionColumns::*published;
  double EvasionRow::*flown;
};
constexpr std::array quantities = {
    Quantity{"min d_O [m]", &EvasionColumns::min_obstacle, &EvasionRow::min_obstacle},
    Quantity{"min d [m]", &EvasionColumns::min_target, &EvasionRow::min_target},
    Quantity{"max d [m]", &EvasionColumns::max_target, &EvasionRow::max_target},
    Quantity{"max alpha_t,ns [rad]", &EvasionColumns::max_angle, &EvasionRow::max_angle},
    Quantity{"out of view after the first view [s]", nullptr, &EvasionRow::lost},
};

}  // namespace

EvasionTrace::EvasionTrace(const Scenario& scenario, const EvasionPlan& plan, Sample sample)
    : team_(scenario.team),
      plan_(plan),
      agent_(body_of(team_, plan.agent)),
      target_(body_of(team_, plan.target)),
      obstacle_(body_of(team_, plan.obstacle)),
      mount_(mount_of(team_, agent_, target_)),
      period_(scenario.horizon.dt),
      every_(std::max<std::int64_t>(1, std::llround(row_time / period_))),
      sample_(std::move(sample)),
      row_{.min_obstacle = infinite,
           .min_target = infinite,
           .max_target = 0.0,
           .max_angle = 0.0,
           .first_view = infinite,
           .lost = 0.0} {
  const auto rows = static_cast<std::size_t>(scenario.simulation.duration / row_time) + 2;
  for (CurveColumn* column :
       {&series_.time, &series_.heading, &series_.to_obstacle, &series_.to_target, &series_.angle})
    column->reserve(rows);
  series_.p.reserve(rows);
  series_.obstacle.reserve(rows);
  series_.target.reserve(rows);
  const auto names = team_.model(agent_).inputs();
  series_.inputs.assign(names.begin(), names.end());
  series_.u.resize(names.size());
  for (CurveColumn& input : series_.u) input.reserve(rows);
}

void EvasionTrace::publish() noexcept {
  const auto sight = [&](BodyId body) { return true_sight(team_, body, sample_); };
  const Sight<double> robot = sight(agent_), target = sight(target_), obstacle = sight(obstacle_);
  const double to_obstacle = norm(robot.p - obstacle.p), to_target = norm(robot.p - target.p);
  const double angle = view_angle(mount_, robot, target.p);
  row_.min_target = std::min(row_.min_target, to_target);
  row_.max_target = std::max(row_.max_target, to_target);
  if (sample_.time >= plan_.from) {
    row_.min_obstacle = std::min(row_.min_obstacle, to_obstacle);
    row_.max_angle = std::max(row_.max_angle, angle);
  }
  const bool seen = angle <= plan_.alpha;
  if (seen) row_.first_view = std::min(row_.first_view, sample_.time);
  if (!seen && row_.first_view < infinite) row_.lost += period_;

  if (samples_++ % every_ != 0 || series_.time.size() == series_.time.capacity()) return;
  series_.time.push_back(sample_.time);
  series_.heading.push_back(std::atan2(robot.d.y, robot.d.x));
  series_.p.push_back(robot.p);
  series_.obstacle.push_back(obstacle.p);
  series_.target.push_back(target.p);
  series_.to_obstacle.push_back(to_obstacle);
  series_.to_target.push_back(to_target);
  series_.angle.push_back(angle);
  const double* const u = sample_.u.data() + team_.input_offset(agent_);
  for (std::size_t i = 0; i < series_.u.size(); ++i) series_.u[i].push_back(u[i]);
}

std::vector<std::vector<std::string>> evasion_table(const EvasionPlan& plan,
                                                    std::span<const EvasionRuns> flown) {
  std::vector<std::vector<std::string>> table;
  const auto add = [&](std::string_view name, std::string_view source, const CurveColumn& values) {
    std::vector<std::string> line = {std::string(name), std::string(source)};
    for (const double value : values) line.push_back(fmt::format("{:.3f}", value));
    table.push_back(std::move(line));
  };
  for (const Quantity& quantity : quantities) {
    if (quantity.published != nullptr && !(plan.published.*quantity.published).empty())
      add(quantity.name, "published", plan.published.*quantity.published);
    for (const EvasionRuns& scenario : flown) {
      CurveColumn values;
      for (const EvasionTrace& run : scenario.runs) values.push_back(run.row().*quantity.flown);
      add(quantity.name, scenario.name, values);
    }
  }
  return table;
}

std::vector<Drawing> evasion_drawings(const EvasionPlan& plan, const EvasionRuns& flown) {
  std::vector<Drawing> drawings;
  const std::string runs = fmt::format("{} runs of {}", flown.runs.size(), flown.name);
  Drawing above{
      fmt::format("{}: paths from above (Fig. 26)", flown.name),
      fmt::format("{} blue, arrows its heading; {} red, dashed; {} green. Every {} s lines join them.",
                  plan.agent, plan.obstacle, plan.target, apart),
      {}};
  above.columns = 2;
  for (std::size_t i = 0; i < flown.runs.size(); ++i)
    above.panels.push_back(paths_panel(flown.runs[i], i + 1, plan.from));
  drawings.push_back(std::move(above));

  const auto place = [](Axis axis) { return [axis](const EvasionSeries& s) { return along(s.p, axis); }; };
  const auto obstacle = [&](Axis axis) {
    return
        [&plan, axis](const EvasionSeries& s) { return since(plan.from, s.time, along(s.obstacle, axis)); };
  };
  drawings.push_back(over_time(
      fmt::format("{}: pose of {} (Fig. 27)", flown.name, plan.agent), runs + ".",
      {panel_of(flown, "x [m]", {}, place(&Vec3<double>::x)),
       panel_of(flown, "y [m]", {}, place(&Vec3<double>::y)),
       panel_of(flown, "z [m]", {}, place(&Vec3<double>::z)),
       panel_of(flown, "psi [rad]", {}, [](const EvasionSeries& s) { return with_gaps(s.heading); })}));
  drawings.push_back(over_time(fmt::format("{}: position of {} (Fig. 28)", flown.name, plan.obstacle),
                               fmt::format("From {} s on, when it enters.", plan.from),
                               {panel_of(flown, "x [m]", {}, obstacle(&Vec3<double>::x)),
                                panel_of(flown, "y [m]", {}, obstacle(&Vec3<double>::y)),
                                panel_of(flown, "z [m]", {}, obstacle(&Vec3<double>::z))}));
  drawings.push_back(over_time(
      fmt::format("{}: distances and view angle (Figs 29 to 31)", flown.name),
      fmt::format("{}; dashed: limits. Distance to {}, to {}, angle of {} off the sensor axis.", runs,
                  plan.obstacle, plan.target, plan.target),
      {panel_of(flown, "d_O [m]", {plan.d_obstacle},
                [&](const EvasionSeries& s) { return since(plan.from, s.time, s.to_obstacle); }),
       panel_of(flown, "d [m]", {plan.d_min, plan.d_max}, [](const EvasionSeries& s) { return s.to_target; }),
       panel_of(flown, "alpha_t [rad]", {plan.alpha}, [](const EvasionSeries& s) { return s.angle; })}));
  if (!flown.runs.empty()) {
    std::vector<Panel> inputs;
    const std::vector<std::string>& names = flown.runs.front().series().inputs;
    for (std::size_t i = 0; i < names.size(); ++i)
      inputs.push_back(panel_of(flown, names[i], {}, [i](const EvasionSeries& s) { return s.u[i]; }));
    drawings.push_back(over_time(fmt::format("{}: inputs of {} (Fig. 32)", flown.name, plan.agent),
                                 runs + ".", std::move(inputs)));
  }
  return drawings;
}

}  // namespace sightline
