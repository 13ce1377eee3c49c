/// What is seen by whom, and what is in the way: [agent.NAME.sensor], .camera, .tags and .hull; the latter two of any body.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// The mount of a robot's sensor, if it has one.
std::optional<SensorMount> read_mount(const TomlTable& agent);

/// The camera of a robot, its tags and its hull; of a target or an obstacle, tags and hull.
/// @param mount  of its sensor
void read_sight(const TomlTable& at, BodyId body, const std::optional<SensorMount>& mount,
                Scenario& scenario);

/// Cameras, tags and hulls, those of vehicles included.
CameraOptions camera_options(const Scenario& scenario);

/// Tags that a robot with a camera has to read at a distance that one of its couplings keeps.
struct TagReading {
  BodyId observer{}, target{};
  std::string key;                               ///< of the coupling, "d_max"
  double distance = 0.0;                         ///< that it keeps [m]
  double pixels = 0.0;                           ///< side of a tag there
  double from_ahead = 0.0, from_any_side = 0.0;  ///< pixels that it takes for every second picture
};
/// In the order of the couplings; nearest first.
std::vector<TagReading> tag_readings(const Scenario& scenario);

/// "camera      uav0: 320 x 240 px, ...", a line for each camera, body with tags and distance.
std::string camera_words(const Scenario& scenario);

}  // namespace sightline
