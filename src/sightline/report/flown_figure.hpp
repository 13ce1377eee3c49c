/// What vehicles planned against what they flew.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/curves.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// The view angles that an observer planned PlannedAhead::ahead before; without rows where it does not lean.
struct PlannedAngles {
  std::vector<double> time, angle;  ///< [s], [rad]
};
PlannedAngles planned_angles(const Recording& recording, const Recording::Pair& pair);

/// Tilt, planned and flown, and distance from the reference of those of the bodies that lean; none where none does.
std::optional<Drawing> flown_drawing(const Recording& recording, const Curves& curves,
                                     const std::vector<std::size_t>& bodies);

/// A table of HTML with a row for each pair and robot that leans; empty where none does.
/// @param summary  text of summary.json
/// @throws std::runtime_error where it is no such summary
std::string flown_table(std::string_view summary);

}  // namespace sightline
