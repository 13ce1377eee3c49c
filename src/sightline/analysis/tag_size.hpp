/// Whether cameras can read tags at the distances that couplings keep.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario/finding.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

struct TagSize {
  std::vector<std::string> refusals;  ///< no camera reads the tags at the nearest distance
  std::vector<std::string> warnings;  ///< at a distance the tags are read seldom, or not from every side
};

/// Judges the size of the tags in pixels, for every coupled pair of a robot with a camera and a
/// body with tags (tag_readings()).
TagSize judge_tag_sizes(const Scenario& scenario);
/// The same as findings before a flight: red for tags that are too small at a distance, else one
/// green finding with the smallest tag's pixels. Empty if no camera observes tags.
std::vector<Finding> tag_findings(const Scenario& scenario);

}  // namespace sightline
