/// Whether tags can be read at the distances that couplings keep.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario/finding.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

struct TagSize {
  std::vector<std::string> refusals;  ///< at the nearest distance no camera reads them
  std::vector<std::string> warnings;  ///< at a distance they are read seldom, or not from every side
};

/// By the pixels that a tag has, of every robot with a camera and body with tags that are coupled (tag_readings()).
TagSize judge_tag_sizes(const Scenario& scenario);
/// The same before a flight: red where tags are too small at a distance, green with the pixels of the smallest; nothing where no camera
/// looks at tags.
std::vector<Finding> tag_findings(const Scenario& scenario);

}  // namespace sightline
