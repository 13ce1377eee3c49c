#include "sightline/solver/newton/influence.hpp"

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

using Arrows = std::vector<std::pair<int, int>>;  // from the observed to the dependent agent

std::vector<int> order_of(const std::vector<std::vector<int>>& feelers) {
  std::vector<int> felt(feelers.size(), 0), order;
  for (const std::vector<int>& list : feelers) {
    for (const int to : list) ++felt[at(to)];
  }
  std::set<std::pair<int, int>> waiting;
  for (std::size_t a = 0; a < felt.size(); ++a) waiting.emplace(felt[a], static_cast<int>(a));
  while (!waiting.empty()) {
    const int next = waiting.begin()->second;
    waiting.erase(waiting.begin());
    order.push_back(next);
    for (const int to : feelers[at(next)]) {
      if (waiting.erase({felt[at(to)], to}) > 0) waiting.emplace(--felt[at(to)], to);
    }
  }
  return order;
}

/// Edges of the longest path to each agent; empty if there is a cycle.
std::vector<int> depths(const std::vector<std::vector<int>>& feelers, const std::vector<int>& order) {
  std::vector<int> depth(feelers.size(), 0), place(feelers.size(), 0);
  for (std::size_t i = 0; i < order.size(); ++i) place[at(order[i])] = static_cast<int>(i);
  for (const int from : order) {
    for (const int to : feelers[at(from)]) {
      if (place[at(to)] < place[at(from)]) return {};
      depth[at(to)] = std::max(depth[at(to)], depth[at(from)] + 1);
    }
  }
  return depth;
}

}  // namespace

InfluenceGraph influence_graph(std::span<const BodyPotential> potentials, int agents,
                               std::span<const SwarmPotential> swarms) {
  Arrows arrows;
  bool all_mutual = true;
  for (const BodyPotential& p : potentials) {
    if (p.a < 0 || p.b < 0) continue;
    all_mutual &= p.ends.a_feels && p.ends.b_feels;
    if (p.ends.a_feels) arrows.emplace_back(p.b, p.a);
    if (p.ends.b_feels) arrows.emplace_back(p.a, p.b);
  }
  for (const SwarmPotential& swarm : swarms) {
    for (std::size_t i = 1; i < swarm.agents.size(); ++i) {
      arrows.emplace_back(swarm.agents[i - 1], swarm.agents[i]);
      arrows.emplace_back(swarm.agents[i], swarm.agents[i - 1]);
    }
  }
  std::sort(arrows.begin(), arrows.end());
  arrows.erase(std::unique(arrows.begin(), arrows.end()), arrows.end());
  InfluenceGraph graph;
  graph.feelers.resize(at(agents));
  for (const auto& [from, to] : arrows) graph.feelers[at(from)].push_back(to);
  graph.order.resize(at(agents));
  std::iota(graph.order.begin(), graph.order.end(), 0);
  if (arrows.empty()) {
    graph.depth_of.resize(at(agents), 0);
    return graph;
  }
  if (all_mutual) {
    graph.kind = Influence::mutual;
    return graph;
  }
  graph.order = order_of(graph.feelers);
  graph.depth_of = depths(graph.feelers, graph.order);
  graph.kind = graph.depth_of.empty() ? Influence::cyclic : Influence::cascade;
  if (!graph.depth_of.empty()) graph.depth = *std::max_element(graph.depth_of.begin(), graph.depth_of.end());
  return graph;
}

}  // namespace sightline
