#include "sightline/report/graph_layout.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace sightline {
namespace {

constexpr double picture_width = 900.0,
                 side_margin = 170.0;  // of the figure; of the names beside the nodes [px]
constexpr double apart_max = 340.0, row_height = 36.0, top_margin = 40.0, letter_width = 8.0;
constexpr double turned_top = 120.0;  // room for a radial name [px]
constexpr std::size_t columns_max = 9, nodes_in_a_column = 18, side_name = 18, turned_name = 12;
constexpr std::size_t crowd = 14;  // most nodes of a circle with horizontal names

using GraphColumn = std::vector<std::size_t>;

/// Nodes by depth; each column is sorted by the mean row of the nodes that its nodes depend on.
std::vector<GraphColumn> columns_of(const NodeGraph& graph, const std::vector<std::size_t>& depths) {
  std::vector<GraphColumn> columns(depths.empty() ? 0 : 1 + *std::max_element(depths.begin(), depths.end()));
  for (std::size_t node = 0; node < depths.size(); ++node) columns[depths[node]].push_back(node);
  std::vector<double> place(depths.size());
  for (GraphColumn& column : columns) {
    std::vector<double> mean(depths.size());
    for (const std::size_t node : column) {
      double sum = 0.0, count = 0.0;
      for (const auto& [from, to] : graph.arrows) {
        if (from == node) sum += place[to], count += 1;
      }
      mean[node] = count > 0 ? sum / count : 0.0;
    }
    std::stable_sort(column.begin(), column.end(),
                     [&](std::size_t a, std::size_t b) { return mean[a] < mean[b]; });
    for (std::size_t i = 0; i < column.size(); ++i) {
      place[column[i]] = static_cast<double>(i) - 0.5 * static_cast<double>(column.size() - 1);
    }
  }
  return columns;
}

GraphLayout in_columns(const NodeGraph& graph, const std::vector<GraphColumn>& columns) {
  const std::size_t last = columns.size() - 1;
  std::size_t longest = 0;
  for (const GraphColumn& column : columns) longest = std::max(longest, column.size());
  const double apart = std::min(
      apart_max, (picture_width - 2 * side_margin) / static_cast<double>(std::max<std::size_t>(last, 1)));
  const double left = 0.5 * (picture_width - apart * static_cast<double>(last));
  GraphLayout layout{
      GraphLayout::Kind::columns, std::vector<GraphLayout::Node>(graph.nodes), picture_width,
      2 * top_margin + row_height * static_cast<double>(longest - 1),
      last > 1 ? std::clamp<std::size_t>(static_cast<std::size_t>(apart / letter_width), 4, side_name)
               : side_name};
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t i = 0; i < columns[c].size(); ++i) {
      const double up = c > 0 && c < last ? -1.0 : 0.0;
      layout.nodes[columns[c][i]] = {
          left + apart * static_cast<double>(c),
          0.5 * layout.height +
              row_height * (static_cast<double>(i) - 0.5 * static_cast<double>(columns[c].size() - 1)),
          up != 0.0 ? 0.0
          : c == 0  ? -1.0
                    : 1.0,
          up};
    }
  }
  return layout;
}

GraphLayout in_a_circle(const NodeGraph& graph, const std::vector<std::size_t>& depths) {
  std::vector<std::size_t> order(graph.nodes);
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (!depths.empty()) {
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return depths[a] < depths[b]; });
  }
  const double turn = 2 * std::numbers::pi / static_cast<double>(std::max<std::size_t>(graph.nodes, 1));
  const double radius =
      graph.nodes < 3 ? 110.0 : std::clamp(row_height / turn, 80.0, 0.5 * picture_width - side_margin);
  const bool crowded = graph.nodes > crowd;
  GraphLayout layout{GraphLayout::Kind::circle,
                     std::vector<GraphLayout::Node>(graph.nodes),
                     picture_width,
                     graph.nodes < 3 ? 2 * top_margin : 2 * (radius + (crowded ? turned_top : top_margin)),
                     crowded ? turned_name : side_name,
                     crowded};
  for (std::size_t i = 0; i < order.size(); ++i) {
    const double angle = std::numbers::pi + turn * static_cast<double>(i);
    const double x = std::cos(angle), y = graph.nodes < 3 ? 0.0 : std::sin(angle);
    layout.nodes[order[i]] = {0.5 * picture_width + radius * x, 0.5 * layout.height + radius * y, x, y};
  }
  return layout;
}

}  // namespace

std::vector<std::size_t> depths_of(const NodeGraph& graph) {
  std::vector<std::size_t> depths(graph.nodes, 0);
  for (std::size_t round = 0; round <= graph.nodes; ++round) {
    bool changed = false;
    for (const auto& [from, to] : graph.arrows) {
      if (depths[from] > depths[to]) continue;
      depths[from] = depths[to] + 1;
      changed = true;
    }
    if (!changed) return depths;
  }
  return {};
}

GraphLayout layout_of(const NodeGraph& graph) {
  const std::vector<std::size_t> depths = depths_of(graph);
  const std::vector<GraphColumn> columns = columns_of(graph, depths);
  const bool fits = !columns.empty() && columns.size() <= columns_max &&
                    std::all_of(columns.begin(), columns.end(),
                                [](const GraphColumn& column) { return column.size() <= nodes_in_a_column; });
  return fits ? in_columns(graph, columns) : in_a_circle(graph, depths);
}

}  // namespace sightline
