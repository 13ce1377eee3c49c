#include "sightline/report/graph_figure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "sightline/base.hpp"
#include "sightline/report/graph_layout.hpp"
#include "sightline/report/page.hpp"
#include "sightline/scenario.hpp"
#include "sightline/solver/newton/influence.hpp"

namespace sightline {
namespace {

constexpr double node_radius = 8.0, head = 9.0;  // of a node, of an arrow's head [px]
constexpr std::size_t many_lines = 150;          // more lines are faint, and mutual ones have no heads

/// A dependency: the first body observes the second, or a coupling with the second acts on it.
using Lean = std::pair<std::size_t, std::size_t>;

bool is_dense(const std::set<Lean>& leans) { return leans.size() > many_lines; }

/// Bodies of a figure: all robots, and the bodies that they depend on.
std::vector<std::size_t> shown_bodies(const Recording& r, const std::set<Lean>& leans) {
  std::set<std::size_t> bodies;
  for (std::size_t i = 0; i < r.bodies.size(); ++i) {
    if (r.bodies[i].is_agent) bodies.insert(i);
  }
  for (const auto& [from, to] : leans) bodies.insert({from, to});
  return {bodies.begin(), bodies.end()};
}

/// Ends of a line with an arrow's head.
enum class Heads { none, at_the_end, at_both };

/// Whether a third node is on the line between two nodes; never on a circle.
bool passes_a_node(const GraphLayout& layout, const GraphLayout::Node& a, const GraphLayout::Node& b) {
  if (layout.kind == GraphLayout::Kind::circle) return false;
  const double dx = b.x - a.x, dy = b.y - a.y, length = norm(dx, dy);
  return std::any_of(layout.nodes.begin(), layout.nodes.end(), [&](const GraphLayout::Node& node) {
    const double along = ((node.x - a.x) * dx + (node.y - a.y) * dy) / length;
    const double off = ((node.y - a.y) * dx - (node.x - a.x) * dy) / length;
    return along > 1.0 && along < length - 1.0 && std::abs(off) < node_radius + 2.0;
  });
}

/// A line between the rims of two nodes, curved if it would cross a third one.
std::string line(const GraphLayout& layout, std::size_t from, std::size_t to, Heads heads,
                 std::string_view id, bool faint) {
  constexpr double bent = 44.0;
  const GraphLayout::Node &a = layout.nodes[from], &b = layout.nodes[to];
  const double dx = b.x - a.x, dy = b.y - a.y, length = norm(dx, dy);
  const double ux = dx / length, uy = dy / length;
  const double bend = passes_a_node(layout, a, b) ? std::copysign(bent, ux) : 0.0;
  const double tail = node_radius + (heads == Heads::at_both ? 3.0 : 1.0), tip = node_radius + 3.0;
  const auto marker = [&](std::string_view end) {
    return fmt::format(" marker-{0}=\"url(#{1}_{0})\"", end, id);
  };
  return fmt::format("<path d=\"M{:.1f} {:.1f} Q{:.1f} {:.1f} {:.1f} {:.1f}\"{}{}{}/>\n", a.x + tail * ux,
                     a.y + tail * uy, 0.5 * (a.x + b.x) - bend * uy, 0.5 * (a.y + b.y) + bend * ux,
                     b.x - tip * ux, b.y - tip * uy, heads == Heads::at_both ? marker("start") : "",
                     heads == Heads::none ? "" : marker("end"), faint ? " opacity=\"0.3\"" : "");
}

std::string node(const GraphLayout& layout, std::size_t i, const Recording::Body& body) {
  // The name is beside the node, away from the others.
  constexpr double gap = node_radius + 8.0, height = 4.5, half_turn = 180.0;
  const GraphLayout::Node& at = layout.nodes[i];
  const bool leftwards = at.out_x<-0.1, rightwards = at.out_x> 0.1;
  const double x = at.x + gap * at.out_x, y = at.y + gap * at.out_y;
  const double angle = std::atan2(at.out_y, at.out_x) * half_turn / std::numbers::pi;
  const bool sideways = leftwards || rightwards || layout.names_turned;
  const bool ends_here = layout.names_turned ? at.out_x < 0.0 : leftwards;
  return fmt::format(
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" {}/>\n<text x=\"{:.1f}\" y=\"{:.1f}\" "
      "text-anchor=\"{}\" style=\"paint-order:stroke;stroke:var(--paper);stroke-width:4px\"{}>{}</text>\n",
      at.x, at.y, node_radius,
      body.is_agent ? "fill=\"#3b82d6\"" : "fill=\"none\" stroke=\"#8a8f98\" stroke-dasharray=\"3 2\"", x,
      sideways ? y + height : y,
      !sideways   ? "middle"
      : ends_here ? "end"
                  : "start",
      layout.names_turned ? fmt::format(" transform=\"rotate({:.1f} {:.1f} {:.1f})\"",
                                        ends_here ? angle + half_turn : angle, x, y)
                          : "",
      escaped(shortened(body.name, layout.name_size)));
}

/// @param id  of the figure; prefix of its marker ids in the page
/// @param towards  whether an arrow points to the dependency or from it
std::string picture(const Recording& r, const std::set<Lean>& leans, std::string_view id, bool towards) {
  const std::vector<std::size_t> bodies = shown_bodies(r, leans);
  std::map<std::size_t, std::size_t> place;
  for (const std::size_t body : bodies) place.emplace(body, place.size());
  NodeGraph graph{bodies.size()};
  for (const auto& [from, to] : leans) graph.arrows.emplace_back(place.at(from), place.at(to));
  const GraphLayout layout = layout_of(graph);

  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" font-family=\"sans-serif\" font-size=\"13\" "
      "fill=\"currentColor\">\n<defs>\n",
      layout.width, layout.height);
  for (const auto& [end, turn] : {std::pair{"start", "auto-start-reverse"}, {"end", "auto"}}) {
    svg += fmt::format(
        "<marker id=\"{}_{}\" viewBox=\"0 0 10 8\" refX=\"9\" refY=\"4\" markerWidth=\"{}\" "
        "markerHeight=\"{}\" markerUnits=\"userSpaceOnUse\" orient=\"{}\"><path d=\"M0 0L10 4L0 "
        "8z\"/></marker>\n",
        id, end, head, 0.8 * head, turn);
  }
  svg += "</defs>\n<g fill=\"none\" stroke=\"currentColor\" stroke-width=\"1.2\">\n";
  for (const auto& [from, to] : leans) {
    const bool mutual = leans.contains({to, from});
    if (mutual && from > to) continue;  // drawn once for both directions
    const std::size_t a = place.at(towards ? from : to), b = place.at(towards ? to : from);
    const Heads of_both = is_dense(leans) ? Heads::none : Heads::at_both;
    svg += line(layout, a, b, mutual ? of_both : Heads::at_the_end, id, is_dense(leans));
  }
  svg += "</g>\n";
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    svg += node(layout, i, r.bodies[bodies[i]]);
  }
  return svg + "</svg>";
}

/// The couplings, and all pairs of a swarm's robots as if they were near.
std::vector<Recording::Coupled> all_coupled(const Recording& r) {
  std::vector<Recording::Coupled> all = r.couplings;
  for (const std::vector<std::size_t>& robots : r.swarms) {
    for (std::size_t i = 0; i < robots.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) all.push_back({robots[i], robots[j], true, true});
    }
  }
  return all;
}

}  // namespace

std::string influence_words(const Recording& recording) {
  std::vector<int> agent(recording.bodies.size(), -1);
  int agents = 0;
  for (std::size_t i = 0; i < agent.size(); ++i) {
    if (recording.bodies[i].is_agent) agent[i] = agents++;
  }
  std::vector<BodyPotential> couplings;
  for (const Recording::Coupled& c : all_coupled(recording)) {
    BodyPotential& entry = couplings.emplace_back();
    entry.a = agent[c.first];
    entry.b = agent[c.second];
    entry.ends.a_feels = c.first_feels;
    entry.ends.b_feels = c.second_feels;
  }
  const InfluenceGraph graph = influence_graph(couplings, agents);
  switch (graph.kind) {
    case Influence::none:
      return "no robot feels another";
    case Influence::mutual:
      return "mutual, every coupling is felt by both of its robots";
    case Influence::cascade:
      return fmt::format("a cascade of depth {}", graph.depth);
    case Influence::cyclic:
      break;
  }
  return "cyclic, some couplings are felt by one side alone and influence comes back";
}

std::vector<Figure> graph_figures(const Recording& recording) {
  if (recording.bodies.size() > graph_bodies_max) return {};
  std::set<Lean> observations, feelings;
  for (const Recording::Pair& pair : recording.pairs) observations.emplace(pair.observer, pair.target);
  for (const Recording::Coupled& c : all_coupled(recording)) {
    if (c.first_feels) feelings.emplace(c.first, c.second);
    if (c.second_feels) feelings.emplace(c.second, c.first);
  }
  const std::string when = recording.script.empty() ? "" : " All of the run, whatever its events change.";
  const std::string heads = is_dense(feelings) ? " Without heads: both ways." : "";
  std::vector<Figure> figures;
  if (!observations.empty()) {
    figures.push_back({"Who observes whom",
                       fmt::format("Arrows: from an observer to what its sensor is kept on.{}", when),
                       picture(recording, observations, "observes", true)});
  }
  if (!feelings.empty()) {
    figures.push_back({"Who influences whom",
                       fmt::format("Arrows: from a body to a robot that feels it; the influence is {}.{}{}",
                                   influence_words(recording), heads, when),
                       picture(recording, feelings, "influences", false)});
  }
  return figures;
}

}  // namespace sightline
