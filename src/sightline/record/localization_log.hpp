/// What robots that are localized by view were told, and what their filters made of it, as a log keeps it.
///
/// Topics of run.mcap, those without another word in JSON, all numbers exactly:
///
///     /ROBOT/motion        {time, t, dt, v, yaw_rate, roll, pitch, gyro, force}: its motion over [t, t + dt], as its autopilot
///                          told it (MotionSample), and `compass` where one told a heading
///     /BODY/broadcast      {time, stamp, p, v, heading, yaw_rate, covariance}: its pose, as it told it by radio and as it
///                          arrived; covariance of (p, heading), upper triangle row by row
///     /ROBOT/estimate      geometry_msgs/PoseWithCovarianceStamped in G, upright; of roll and pitch nothing is said
///     /ROBOT/localization  {time, stamp, accepted, p, v, heading, yaw_rate, covariance}: the same with velocity, and the stamp
///                          of the last measurement that was believed
///     /ROBOT/innovation    {time, target, stamp, verdict, dimension, squared, y}: how a detection of that exposure fitted
///                          (DetectionFit), in the order of arrival
///
/// There is no estimate, and none of these messages, before a robot is localized. A replay reads motions, broadcasts and
/// detections (recorded_flight.hpp), and compares what it makes of them with /ROBOT/localization.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sightline/record/log_text.hpp"
#include "sightline/record/mcap.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// Writes the topics above.
class LocalizationLog {
 public:
  /// The sink outlives this.
  LocalizationLog(const Scenario& scenario, MessageSink& sink);

  /// Adds a sample; allocates nothing once the buffers have grown.
  void add(const Sample& sample);

 private:
  struct Robot {
    BodyId body{};
    McapChannel motion, estimate, localization, innovation;
  };
  struct Sender {
    BodyId body{};
    McapChannel broadcast;
  };
  void add_motion(const RobotMotion& reported, double time);
  void add_broadcast(const BodyBroadcast& reported, double time);
  void add_estimate(Robot& robot, const PoseEstimate& estimate, double time);
  void add_fit(const DetectionFit& fit, double time);
  Robot* robot(BodyId body);

  Team team_;
  MessageSink& sink_;
  LogMessage message_;
  std::vector<Robot> robots_;
  std::vector<Sender> senders_;
  std::vector<std::byte> bytes_;
};

/// Messages of those topics, read again.
/// @throws std::runtime_error for a message that is none of them
MotionSample motion_of(const LogText& text);
BroadcastPose broadcast_of(const LogText& text);
PoseEstimate estimate_of(const LogText& text);

}  // namespace sightline
