/// Recordings of camera rigs among AprilTags, in the files of TagSLAM or with a bag of ROS 2.
#pragma once

#include <filesystem>
#include <string_view>

#include "sightline/readers/rig_recording.hpp"

namespace sightline {

/// Whether a place is such a recording: a folder with tagslam.yaml, a prefix PREFIX of
/// PREFIX_tagslam.yaml, or a bag PREFIX.mcap.
bool is_rig_recording(const std::filesystem::path& place);

/// Reads tagslam.yaml (bodies and tags), cameras.yaml, camera_poses.yaml, tag_detections.csv and,
/// where it is, reference.csv; the last two perhaps with .gz (RigRows). The one body of cameras moves;
/// tags are those of static bodies. A tag that no body has belongs to `default_body`, if there is one.
/// Tags of other bodies, and `ignore_tags`, are left out, and so is the reference outside [start, end].
/// Refused: more than 500 tags seen, `squash`, remaps of one camera, bodies of another type than simple.
///
/// Without tag_detections.csv, and if PREFIX.mcap is the place, sightings and odometry are those of the
/// bag (RosBag::rig): PREFIX.mcap, or those of the folder. Without cameras.yaml its cameras are those that
/// see tags. Each has a frame with one CameraInfo, that of its rectified picture, which /tf_static joins to
/// the body that moves or to that of its odometry. `imu_topic` of the body that moves names the
/// sensor_msgs/Imu whose angular velocity counts; T_body_imu has its pose where /tf_static has not.
/// @param pixels  of such cameras: "raw", "rectified", or empty where both are the same
/// @throws ScenarioError or std::invalid_argument naming file, key, value and what was expected
RigRecording read_rig_recording(const std::filesystem::path& place, std::string_view pixels = "");

}  // namespace sightline
