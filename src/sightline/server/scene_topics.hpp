/// A flight as Foxglove and rviz draw and judge it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sightline/record/mcap.hpp"
#include "sightline/server/scene.hpp"
#include "sightline/server/scene_json.hpp"

namespace sightline {

/// Makes, of states that are shown,
///
///   /tf           tf2_msgs/msg/TFMessage: where robots, targets and obstacles are in "map", each state
///   /scene        visualization_msgs/msg/MarkerArray: what Scene draws, each 0.1 s
///   /diagnostics  diagnostic_msgs/msg/DiagnosticArray: of the solver and of each robot, each 0.1 s
///
/// in the layouts that the bridge of ROS 2 publishes.
class SceneTopics {
 public:
  /// Opens the topics. `to` outlives this.
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
  std::int64_t tenth_ = -1;                         // of simulated time, that the last state was in
  std::vector<std::optional<Sight<double>>> seen_;  // that are finite
  std::vector<std::byte> bytes_;
};

}  // namespace sightline
