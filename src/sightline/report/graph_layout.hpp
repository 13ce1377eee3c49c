/// Layout of the nodes of a graph.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace sightline {

/// Nodes 0 .. nodes - 1; each arrow (a, b) means that a depends on b.
struct NodeGraph {
  std::size_t nodes = 0;
  std::vector<std::pair<std::size_t, std::size_t>> arrows{};
};

/// Number of arrows on the longest path from each node; empty if the graph has a cycle.
std::vector<std::size_t> depths_of(const NodeGraph& graph);

/// Positions in a figure, x to the right and y down.
struct GraphLayout {
  enum class Kind {
    columns,  ///< by depth: nodes without dependencies are on the left
    circle,   ///< clockwise from the left, in the order of depths if there are any, else of nodes
  };
  struct Node {
    double x, y;          ///< [px]
    double out_x, out_y;  ///< unit vector towards its name, away from other nodes
    bool operator==(const Node&) const = default;
  };

  Kind kind{};
  std::vector<Node> nodes{};
  double width = 0.0, height = 0.0;  ///< of the figure [px]
  std::size_t name_size = 0;         ///< most characters of a name
  bool names_turned = false;         ///< names are radial, where they would overlap otherwise
};

/// Columns for few and short columns, otherwise a circle. Equal graphs have equal layouts.
GraphLayout layout_of(const NodeGraph& graph);

}  // namespace sightline
