/// Where the nodes of a graph are drawn.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace sightline {

/// Nodes 0 .. nodes - 1; each arrow goes from one that leans on another to that other.
struct NodeGraph {
  std::size_t nodes = 0;
  std::vector<std::pair<std::size_t, std::size_t>> arrows{};
};

/// The arrows of the longest path that leaves each node; empty where arrows run in a circle.
std::vector<std::size_t> depths_of(const NodeGraph& graph);

/// A picture's places, x to the right and y down.
struct GraphLayout {
  enum class Kind {
    columns,  ///< by depth: what leans on nothing stands left
    circle,   ///< in the order of the depths where there are any, else of the nodes, clockwise from the left
  };
  struct Node {
    double x, y;          ///< [px]
    double out_x, out_y;  ///< unit vector towards its name, away from the others
    bool operator==(const Node&) const = default;
  };

  Kind kind{};
  std::vector<Node> nodes{};
  double width = 0.0, height = 0.0;  ///< of the picture [px]
  std::size_t name_size = 0;         ///< characters that find room
  bool names_turned = false;         ///< along the way out, where they would lie upon each other
};

/// Columns where there are few of them and none is long, a circle otherwise. The same graph has the same layout.
GraphLayout layout_of(const NodeGraph& graph);

}  // namespace sightline
