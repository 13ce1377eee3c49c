#include "sightline/scenario/tag_size.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sightline/scenario/read_camera.hpp"

namespace sightline {

std::string describe(const TagReading& one, const Team& team) {
  return fmt::format("a tag of {} has {:.1f} px for the camera of {} at {} = {} m", team.name(one.target),
                     one.pixels, camera_name(*one.camera, team), one.key, one.distance);
}

TagSize judge_tag_sizes(const Scenario& scenario) {
  TagSize judged;
  const std::vector<TagReading> readings = tag_readings(scenario);
  for (const TagReading& one : readings) {
    const std::string what = describe(one, scenario.team);
    const bool is_nearest = std::none_of(readings.begin(), readings.end(), [&](const TagReading& other) {
      return other.camera == one.camera && other.target == one.target && other.distance < one.distance;
    });
    if (one.pixels < one.from_ahead && is_nearest) {
      judged.refusals.push_back(fmt::format("{}: {}, expected at least {} px, or it is not read",
                                            scenario.file.native(), what, one.from_ahead));
    } else if (one.pixels < one.from_ahead) {
      judged.warnings.push_back(fmt::format("{}, below {} px it is not read", what, one.from_ahead));
    } else if (one.pixels < one.from_any_side) {
      judged.warnings.push_back(
          fmt::format("{}, below {:.1f} px it is not read from every side", what, one.from_any_side));
    }
  }
  return judged;
}

}  // namespace sightline
