/// Makes scenarios, fleets and parts of them from the files of other programs.
///
///     crazyflies.yaml, server.yaml   Crazyswarm2            a fleet file
///     camera_info, camchain (YAML)   ROS 2, kalibr          [agent.NAME.camera]
///     CameraInfo in a bag (MCAP)     ROS 2                  [agent.NAME.camera]
///     tags.yaml                      apriltag_ros, TagSLAM  [target.NAME.tags]
///     model.sdf, URDF, MJCF          Gazebo, ROS, MuJoCo    [agent.NAME.vehicle]
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

struct ImportOptions {
  std::string
      agent{};  ///< robot that gets a camera or a vehicle, by default uav0, or all the tags; empty: each tag a target
  std::string camera{};  ///< of a camchain, "cam1", or a topic of a bag; empty: its first
};

/// The result: a file, or tables of one.
struct Imported {
  std::string what;                ///< "a fleet of 2 robots"
  std::string text;                ///< TOML
  std::vector<std::string> notes;  ///< sentences about what has no counterpart
};

/// A file to import, in memory.
struct ImportFile {
  std::string name;  ///< as in error messages
  std::string text;
};

/// Makes what the files stand for, by the kind of the first.
/// @throws ScenarioError for a file that cannot be read, or that is of no known kind, with place, key,
/// value and what was expected
Imported import_files(std::span<const std::filesystem::path> files, const ImportOptions& options = {});
/// The same from texts.
Imported import_texts(std::span<const ImportFile> files, const ImportOptions& options = {});

}  // namespace sightline
