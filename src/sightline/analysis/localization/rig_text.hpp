/// Results of a localized camera rig as text, JSON, HTML and log.
#pragma once

#include <filesystem>
#include <string>

#include "sightline/analysis/localization/localize_rig.hpp"
#include "sightline/log.hpp"

namespace sightline {

struct LocalizedRig {
  std::string place, command;  ///< path of the recording; command line
  const RigRecording& recording;
  const RigNoise& noise;
  const RigLocalization& result;
  bool identified = false;  ///< the random walks are those of identify_motion()
};

std::string to_string(const LocalizedRig& localized);
std::string to_json(const LocalizedRig& localized);
std::string to_html(const LocalizedRig& localized);
/// Writes /RIG/estimate of the filter, /RIG_smoothed/estimate, /RIG/pose of the aligned reference, and
/// /RIG/innovation. Log time is the time since the start of the recording. Equal runs give equal bytes.
/// @throws std::runtime_error naming the file, if a part of it is lost
void write_rig_log(const std::filesystem::path& file, const LocalizedRig& localized);

}  // namespace sightline
