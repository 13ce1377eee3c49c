/// Reads cameras, tags and hulls: [agent.NAME.sensor], .sensors and .camera of robots, .tags and .hull of any
/// body.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/scenario.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// The mount of a robot's sensor, if it has one.
std::optional<SensorMount> read_mount(const TomlTable& agent);
/// Its further sensors, in the order of the file.
std::vector<NamedSensor> read_sensors(const TomlTable& agent);

/// Reads the cameras of a robot, and the tags and the hull of any body, into scenario.vision.
/// @param sensors  of the body, if it has any
void read_sight(const TomlTable& at, BodyId body, const Observer& sensors, ScenarioSpec& scenario);

/// Cameras, tags and hulls, including the hulls of vehicles.
CameraOptions camera_options(const ScenarioSpec& scenario);

/// Whether pictures are rendered for a camera, to find tags in them.
bool renders_pictures(const CameraOptions& options);

/// Size of a target's tags in the image of an observer, at a distance that a coupling states.
struct TagReading {
  const RobotCamera* camera = nullptr;  ///< of the scenario
  BodyId target{};
  std::string key;                               ///< of the coupling, "d_max"
  double distance = 0.0;                         ///< that the coupling keeps [m]
  double pixels = 0.0;                           ///< side of a tag in the image at that distance [px]
  double from_ahead = 0.0, from_any_side = 0.0;  ///< sides at which half of the pictures give a detection
                                                 ///< [px]
};
/// In the order of the couplings; d_min before d_max.
std::vector<TagReading> tag_readings(const ScenarioSpec& scenario);

/// "uav0", or "uav0 left" of a camera at [agent.uav0.sensors.left].
std::string camera_name(const RobotCamera& camera, const Team& team);

/// "camera      uav0: 320 x 240 px, ...", a line for each camera, body with tags and distance.
std::string camera_words(const ScenarioSpec& scenario);

}  // namespace sightline
