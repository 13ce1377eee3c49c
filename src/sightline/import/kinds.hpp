/// The kinds of files that import.hpp makes something of, and TOML of values.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "sightline/import/import.hpp"
#include "sightline/import/yaml_value.hpp"
#include "sightline/readers/ros_bag.hpp"

namespace sightline {

// Each takes a document, and the name of its file.
// @throws ScenarioError for a value that has no meaning for us

/// @param server  parameters of the server's node; null: not given
Imported import_crazyflies(const YamlValue& robots, const std::string& file, const YamlValue* server);
Imported import_camera_info(const YamlValue& camera, const std::string& file, const ImportOptions& options);
Imported import_camchain(const YamlValue& chain, const std::string& file, const ImportOptions& options);

/// @param bag  a file or a folder
Imported import_bag(const std::filesystem::path& bag, const ImportOptions& options);

/// A camera of ROS, calibrated as camera_calibration writes it. @throws ScenarioError
Camera ros_camera(const YamlValue& camera);
/// The same text of a camera in a bag. @param file  name for messages @throws ScenarioError
YamlValue calibration_of(const std::string& file, const BagCamera& camera);
/// A pinhole camera of a camchain, with the lens radtan, equidistant or none. @throws ScenarioError
Camera kalibr_camera(const YamlValue& camera);
/// @param document  parameters of apriltag_ros, a list standalone_tags, or bodies of TagSLAM
Imported import_tags(const YamlValue& document, const std::string& file, const ImportOptions& options);

/// @param files  a URDF, an MJCF, or those of one model of SDF: its own, and those that it includes
Imported import_vehicle(std::span<const ImportFile> files, const ImportOptions& options);

/// The parameters of a node of ROS 2, ros__parameters; none in another file.
std::optional<YamlValue> node_parameters(const YamlValue& document);
/// Whether a robot may have this name.
bool is_robot_name(std::string_view name);

/// "crazyflies.yaml" of a path, for comments.
std::string file_name(const std::string& file);
/// A number that reads back as the same number, with a point.
std::string toml_number(double value);
/// "[0.1, 0.2]"
std::string toml_numbers(std::span<const double> values);

}  // namespace sightline
