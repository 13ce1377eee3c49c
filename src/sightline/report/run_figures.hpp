/// Figures of a run's page, a source file each.
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

/// Six views, evenly spaced in time, of each of the first four cameras with detections: the plates
/// that face the camera, at their detected poses. The code of a tag is not drawn.
std::vector<Figure> camera_figures(const Recording& recording);

/// For each of the first robots that are localized by view: error with three standard deviations,
/// NEES, and the fit of its detections.
std::vector<Drawing> localization_drawings(const Recording& recording);

/// Paths from above. Each 1.67 s a line from observer to target and the observer's heading, as in
/// Fig. 20. At the end the footprint of each observer's cone: the horizontal section of the cone at
/// its depression. Below, the paths in the longer of x and y over z.
Drawing paths_drawing(const Recording& recording, const Curves& curves);

/// Fallback levels of the robots over time, and intervals in which the barrier acted. None if the
/// run had neither supervisor nor barrier, or neither acted.
std::optional<Drawing> safety_drawing(const Recording& recording);

/// Distance of the two nearest robots, number of pairs kept apart, and distance of the robots from
/// their final references; none if no robots are kept apart.
std::optional<Drawing> swarm_drawing(const Recording& recording);

}  // namespace sightline
