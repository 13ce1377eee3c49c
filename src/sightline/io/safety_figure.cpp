#include "sightline/io/safety_figure.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/safety/ladder.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Curve = Drawing::Curve;
using Panel = Drawing::Panel;

constexpr std::size_t robots_shown = Drawing::colours;

/// The rung of a robot over time, as steps; empty where it never left the first.
Curve rungs_of(const Recording& r, std::size_t robot) {
  Curve steps{r.bodies[robot].name, robot % Drawing::colours, Mark::line, {}, {}};
  double rung = 0.0;
  const auto corner = [&](double t) {
    steps.x.push_back(t);
    steps.y.push_back(rung);
  };
  for (const Recording::Event& event : r.events) {
    if (event.value != static_cast<double>(robot)) continue;
    for (int i = 0; i < rung_count; ++i) {
      if (event.kind != to_string(static_cast<Rung>(i))) continue;
      if (steps.x.empty()) corner(r.time.front());
      corner(event.time);
      rung = i;
      corner(event.time);
    }
  }
  if (!steps.x.empty()) corner(r.time.back() + r.period);
  return steps;
}

/// Where the barrier acted: a line at the robot's own height, with gaps.
Curve acts_of(const Recording& r, std::size_t robot, double height) {
  const Recording::Body& body = r.bodies[robot];
  Curve acts{body.name, robot % Drawing::colours, Mark::line, {}, {}};
  for (std::size_t k = 0; k < std::min(body.barrier.size(), r.time.size()); ++k) {
    const bool acted = body.barrier[k] > 0, before = k > 0 && body.barrier[k - 1] > 0;
    if (acted == before) continue;
    // A gap ends where it begins again: what is not a number is not drawn.
    if (acted && !acts.x.empty()) acts.x.push_back(r.time[k]), acts.y.push_back(std::nan(""));
    acts.x.push_back(r.time[k]);
    acts.y.push_back(height);
  }
  if (acts.x.size() % 3 == 1) acts.x.push_back(r.time.back() + r.period), acts.y.push_back(height);
  return acts;
}

}  // namespace

std::optional<Drawing> safety_drawing(const Recording& recording) {
  if (recording.time.empty()) return std::nullopt;
  Panel rungs{.x_label = "", .y_label = "rung", .height = 180},
      barrier{.x_label = "t [s]", .y_label = "barrier acts", .height = 140};
  double height = 0.0;
  for (std::size_t i = 0; i < std::min(recording.bodies.size(), robots_shown); ++i) {
    if (!recording.bodies[i].is_agent) continue;
    if (Curve steps = rungs_of(recording, i); !steps.x.empty()) rungs.curves.push_back(std::move(steps));
    height += 1.0;
    if (Curve acts = acts_of(recording, i, height); !acts.x.empty())
      barrier.curves.push_back(std::move(acts));
  }
  Drawing drawing{
      "Safety",
      "Rungs of the ladder: 0 valid, 1 predicted, 2 slowed, 3 hold, 4 land, 5 grounded. Below, when the "
      "barrier changed a command; one height for each robot.",
      {}};
  for (Panel* panel : {&rungs, &barrier}) {
    if (!panel->curves.empty()) drawing.panels.push_back(std::move(*panel));
  }
  if (drawing.panels.empty()) return std::nullopt;
  drawing.panels.back().x_label = "t [s]";
  return drawing;
}

}  // namespace sightline
