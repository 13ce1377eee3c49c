/// Planned against flown motion of vehicles.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/report.hpp"
#include "sightline/report/curves.hpp"

namespace sightline {

/// View angles that an observer planned PlannedAhead::ahead earlier; empty if the observer does not
/// tilt.
struct PlannedAngles {
  std::vector<double> time, angle;  ///< [s], [rad]
};
PlannedAngles planned_angles(const Recording& recording, const Recording::Pair& pair);

/// Planned and flown tilt, and distance from the reference, of the bodies that tilt; none without
/// such a body.
std::optional<Drawing> flown_drawing(const Recording& recording, const Curves& curves,
                                     const std::vector<std::size_t>& bodies);

/// HTML table with a row for each pair and robot that tilts; empty without such a robot.
/// @param summary  text of summary.json
/// @throws std::runtime_error if it is no such summary
std::string flown_table(std::string_view summary);

}  // namespace sightline
