/// Topics of run.mcap, which the writers of the log open and docs/reference.md lists.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "sightline/log.hpp"

namespace sightline {

/// A topic; BODY, ROBOT and OBSERVER stand for the names of bodies, SENSOR for that of a sensor.
struct LogTopic {
  std::string_view topic, schema;
  std::string_view fields;  ///< of a message in JSON, after its `time`: "number, list[], word: string"
  std::string_view meaning;

  constexpr std::string_view encoding() const { return schema.starts_with("sightline.") ? "json" : "cdr"; }
  /// The topic of a body, of its sensor BODY/SENSOR, or of none.
  std::string of(std::string_view body = {}) const {
    return std::string(body.empty() ? "" : "/").append(body).append(topic.substr(topic.rfind('/')));
  }
  /// @param ros2msg  definition of the message; empty: in JSON
  SchemaId add_schema(MessageSink& to, std::string_view ros2msg = {}) const {
    if (!ros2msg.empty()) return to.schema(schema, "ros2msg", ros2msg);
    return to.schema(schema, "jsonschema", json_schema(fields));
  }
  McapChannel open(MessageSink& to, SchemaId id, std::string_view body = {}) const {
    return {to.channel(id, of(body), encoding(), {})};
  }
};

inline constexpr std::array<LogTopic, 24> log_topics = {
    {{"/BODY/state", "sightline.State", "x[]", "true state"},
     {"/BODY/pose", "geometry_msgs/msg/PoseStamped", "", "true pose in G"},
     {"/BODY/twist", "geometry_msgs/msg/TwistStamped", "", "true velocity in G, yaw rate"},
     {"/BODY/attitude", "geometry_msgs/msg/QuaternionStamped", "",
      "of vehicles and of robots with a body-fixed camera"},
     {"/BODY/measured", "geometry_msgs/msg/PoseStamped", "", "measured pose, if measurements have errors"},
     {"/BODY/measurement", "sightline.Measurement", "stamp, x[]",
      "measured state that controllers receive, and its time; null: not finite, none yet"},
     {"/BODY/broadcast", "sightline.Broadcast", "stamp, p[], v[], heading, yaw_rate, covariance[]",
      "pose as received by radio; upper triangle of the covariance of p and heading"},
     {"/ROBOT/input", "sightline.Input", "u[], raw[]", "applied input, and the solver's"},
     {"/ROBOT/path", "nav_msgs/msg/Path", "", "predicted poses"},
     {"/ROBOT/reference", "sightline.Reference", "p[], d[]",
      "position [m] and heading of the reference that Q weighs, each 0.1 s"},
     {"/ROBOT/barrier", "sightline.Barrier", "active: boolean, conflict: boolean, reserve",
      "whether the command was changed, whether none satisfied all conditions, reserve [m]"},
     {"/ROBOT/view", "sightline.View",
      "certified: boolean, active: boolean, reserve, least: string, target: string, requests: boolean",
      "whether its view of the target is certified, whether the command was changed for it, least reserve "
      "[m], and its name or the condition that is missed; the target is empty if no view is in force; "
      "whether it is requested to "
      "slow down"},
     {"/ROBOT/goal", "sightline.Goal", "after[], p[], heading[]",
      "goal that a user sent, as successive waypoints"},
     {"/ROBOT/motion", "sightline.Motion", "t, dt, v[], yaw_rate, roll, pitch, gyro[], force[], compass",
      "motion over [t, t + dt] as the autopilot reports it; `compass` if it reports a heading"},
     {"/ROBOT/estimate", "geometry_msgs/msg/PoseWithCovarianceStamped", "",
      "estimated pose in G, upright; no information on roll and pitch"},
     {"/ROBOT/localization", "sightline.Localization",
      "stamp, accepted, p[], v[], heading, yaw_rate, covariance[]",
      "estimate with all digits, stamp of the last accepted measurement, covariance of p and heading"},
     {"/ROBOT/innovation", "sightline.Innovation",
      "target: string, stamp, verdict: string, dimension: integer, squared, y[]",
      "fit of a detection; squared: y^T S^-1 y, chi² with `dimension` degrees of freedom"},
     {"/OBSERVER/detection", "sightline.Detection",
      "stamp, arrival, target: string, tags, p[], q[], covariance[]",
      "times of exposure and arrival [s], number of tags, position [m] and attitude (w, x, y, z; zeros: "
      "unknown) of the target in the camera frame, upper triangle of the covariance of position and turn"},
     {"/OBSERVER/camera_info", "sensor_msgs/msg/CameraInfo", "",
      "of its first camera, once, with its distortion"},
     {"/OBSERVER/SENSOR/camera_info", "sensor_msgs/msg/CameraInfo", "",
      "of each further camera, at [agent.OBSERVER.sensors.SENSOR]"},
     {"/solver", "sightline.Solver", "status: string, residual, iterations: integer, pairs: integer, cost",
      "of an update, `pairs` with [[keep_apart]]; of several controllers /controllerN/solver"},
     {"/events", "sightline.Event", "kind: string, controller: integer, value",
      "[kinds](notation.md#events)"},
     {"/team", "sightline.TeamAnswer", "", "a requested team took effect in this period or was refused"},
     {"/tuned", "sightline.Tuned", "number: integer, name: string, text: string",
      "an event that a viewer added in flight"}}};

/// The topic of that name; any other does not compile.
consteval LogTopic log_topic(std::string_view name) {
  for (const LogTopic& one : log_topics)
    if (one.topic == name) return one;
  throw "a topic without a description";
}

}  // namespace sightline
