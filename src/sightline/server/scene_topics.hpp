/// Topics of a flight for Foxglove and rviz.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/report/scene.hpp"
#include "sightline/server/scene_json.hpp"

namespace sightline {

/// Publishes, from the states of a flight,
///
///   /tf           tf2_msgs/msg/TFMessage: poses of robots, targets, obstacles in "map", each state
///   /scene        visualization_msgs/msg/MarkerArray: the primitives of Scene, each 0.1 s
///   /diagnostics  diagnostic_msgs/msg/DiagnosticArray: of the solver and of each robot, each 0.1 s
///
/// in the layouts of the ROS 2 bridge.
class SceneTopics {
 public:
  /// Opens the topics. `to` must outlive this object.
  SceneTopics(const Scenario& scenario, MessageSink& to);

  void add(const ShownState& state);

 private:
  void send_transforms(const ShownState& state);
  void send_scene(const ShownState& state);
  void send_diagnostics(const ShownState& state);
  void send(McapChannel& channel, double time);

  Scene scene_;
  std::vector<std::string> names_;  // of the bodies
  std::vector<BodyId> robots_;
  MessageSink& to_;
  McapChannel transforms_, markers_, diagnostics_;
  std::int64_t tenth_ = -1;                         // index of the 0.1 s interval of the last state
  std::vector<std::optional<Sight<double>>> seen_;  // only finite ones
  std::vector<std::byte> bytes_;
};

}  // namespace sightline
