/// Whether cameras can read tags at the distances that couplings keep.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

struct TagReading;

struct TagSize {
  std::vector<std::string> refusals;  ///< no camera reads the tags at the nearest distance
  std::vector<std::string> warnings;  ///< at a distance the tags are read seldom, or not from every side
};

/// Judges the size of the tags in pixels, for every coupled pair of a robot with a camera and a
/// body with tags (tag_readings()).
TagSize judge_tag_sizes(const Scenario& scenario);
/// "a tag of b has 13.9 px for the camera of a at d_max = 3 m"
std::string describe(const TagReading& one, const Team& team);

}  // namespace sightline
