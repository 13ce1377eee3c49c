/// Recordings of camera rigs among AprilTags, in the files of TagSLAM.
#pragma once

#include <filesystem>

#include "sightline/readers/rig_recording.hpp"

namespace sightline {

/// Whether a place is such a recording: a folder with tagslam.yaml, or a prefix PREFIX of
/// PREFIX_tagslam.yaml.
bool is_rig_recording(const std::filesystem::path& place);

/// Reads tagslam.yaml (bodies and tags), cameras.yaml, camera_poses.yaml, tag_detections.csv and,
/// where it is, reference.csv; the last two perhaps with .gz (RigRows). The one body of cameras moves;
/// tags are those of static bodies. A tag that no body has belongs to `default_body`, if there is one.
/// Tags of other bodies, and `ignore_tags`, are left out, and so is the reference outside [start, end].
/// Refused: more than 500 tags seen, `squash`, remaps of one camera, bodies of another type than simple.
/// @throws ScenarioError or std::invalid_argument naming file, key, value and what was expected
RigRecording read_rig_recording(const std::filesystem::path& place);

}  // namespace sightline
