/// Least distances of bodies.
#pragma once

#include <optional>
#include <vector>

#include "sightline/report/curves.hpp"

namespace sightline {

/// Two bodies, at least one of them a robot, by their indices in `bodies`.
struct Nearness {
  std::size_t first, second;
  double least;  ///< [m]
};

/// The pairs with the least distances, ascending. For a long flight of many bodies only every few
/// periods count. Omits pairs that were never present at once.
std::vector<Nearness> nearest_pairs(const Recording& recording, std::size_t most);

/// Distances over time of the six nearest pairs, with the hard distances. None for a team with a
/// single pair, whose distance another figure shows, and no hard distance.
std::optional<Drawing> nearness_drawing(const Recording& recording, const Curves& curves);

}  // namespace sightline
