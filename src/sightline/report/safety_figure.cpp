#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/report/run_figures.hpp"
#include "sightline/supervisor.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Curve = Drawing::Curve;
using Panel = Drawing::Panel;

constexpr std::size_t robots_shown = Drawing::colours;

/// Fallback level of a robot over time, as steps; empty if it never changed.
Curve levels_of(const Recording& r, std::size_t robot) {
  Curve steps{r.bodies[robot].name, robot % Drawing::colours, Mark::line, {}, {}};
  double level = 0.0;
  const auto corner = [&](double t) {
    steps.x.push_back(t);
    steps.y.push_back(level);
  };
  for (const Recording::Event& event : r.events) {
    if (event.value != static_cast<double>(robot)) continue;
    for (int i = 0; i < fallback_level_count; ++i) {
      if (event.kind != to_string(static_cast<FallbackLevel>(i))) continue;
      if (steps.x.empty()) corner(r.time.front());
      corner(event.time);
      level = i;
      corner(event.time);
    }
  }
  if (!steps.x.empty()) corner(r.end());
  return steps;
}

/// Intervals in which the barrier acted: a line at the robot's own height, with gaps.
Curve acts_of(const Recording& r, std::size_t robot, double height) {
  const Recording::Body& body = r.bodies[robot];
  Curve acts{body.name, robot % Drawing::colours, Mark::line, {}, {}};
  for (std::size_t k = 0; k < std::min(body.barrier.size(), r.time.size()); ++k) {
    const bool acted = body.barrier[k] > 0, before = k > 0 && body.barrier[k - 1] > 0;
    if (acted == before) continue;
    // NaN ends a gap where the barrier acts again.
    if (acted && !acts.x.empty()) acts.x.push_back(r.time[k]), acts.y.push_back(std::nan(""));
    acts.x.push_back(r.time[k]);
    acts.y.push_back(height);
  }
  if (acts.x.size() % 3 == 1) acts.x.push_back(r.end()), acts.y.push_back(height);
  return acts;
}

}  // namespace

std::optional<Drawing> safety_drawing(const Recording& recording) {
  if (recording.time.empty()) return std::nullopt;
  Panel levels{.x_label = "", .y_label = "", .height = 180},
      barrier{.x_label = "t [s]", .y_label = "", .height = 140};
  double height = 0.0;
  barrier.y_names = {""};
  for (std::size_t i = 0; i < std::min(recording.bodies.size(), robots_shown); ++i) {
    if (!recording.bodies[i].is_agent) continue;
    if (Curve steps = levels_of(recording, i); !steps.x.empty()) levels.curves.push_back(std::move(steps));
    height += 1.0;
    barrier.y_names.push_back(label(recording.bodies[i].name, 10));
    if (Curve acts = acts_of(recording, i, height); !acts.x.empty())
      barrier.curves.push_back(std::move(acts));
  }
  Drawing drawing{"Safety", "", {}};
  if (!levels.curves.empty()) {
    for (int i = 0; i < fallback_level_count; ++i)
      levels.y_names.emplace_back(to_string(static_cast<FallbackLevel>(i)));
    levels.y_range = {{-0.3, fallback_level_count - 0.7}};
    drawing.caption = "What each robot flew by as its data grew old.";
  }
  if (!barrier.curves.empty()) {
    barrier.y_range = {{0.4, height + 0.6}};
    drawing.caption += fmt::format("{}Lines: when the barrier changed a robot's command.",
                                   drawing.caption.empty() ? "" : " ");
  }
  for (Panel* panel : {&levels, &barrier}) {
    if (!panel->curves.empty()) drawing.panels.push_back(std::move(*panel));
  }
  if (drawing.panels.empty()) return std::nullopt;
  drawing.panels.back().x_label = "t [s]";
  return drawing;
}

}  // namespace sightline
