/// How near bodies came to each other.
#pragma once

#include <optional>
#include <vector>

#include "sightline/report/curves.hpp"

namespace sightline {

/// Two bodies, of which one is a robot at least, by their numbers in `bodies`.
struct Nearness {
  std::size_t first, second;
  double least;  ///< [m]
};

/// The pairs that came nearest, the nearest first; of a long flight of many bodies every few periods are looked at.
/// Pairs that were never there at once are left out.
std::vector<Nearness> nearest_pairs(const Recording& recording, std::size_t most);

/// The distances of the six pairs that came nearest, over time, with the hard distances; none where the team has
/// one pair alone, of which another figure tells the distance, and no hard distance.
std::optional<Drawing> nearness_drawing(const Recording& recording, const Curves& curves);

}  // namespace sightline
