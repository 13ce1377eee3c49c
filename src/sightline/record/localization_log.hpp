/// Log of vision-localized robots: inputs and estimates of their filters.
///
/// Before a robot is localized there is no estimate, so neither /ROBOT/estimate nor
/// /ROBOT/localization. A replay reads motions, broadcasts and detections (RecordedFlight) and
/// compares its estimates with /ROBOT/localization.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Writes motions, broadcasts, estimates, localizations and innovations (log_table.hpp).
class LocalizationLog {
 public:
  /// @param sink  receives the messages; must outlive this object
  LocalizationLog(const Scenario& scenario, MessageSink& sink);

  /// Adds a sample; allocates nothing once the buffers have reached their final size.
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

/// Decode messages of these topics.
/// @throws std::runtime_error if the message is of another kind
MotionSample motion_of(const LogText& text);
BroadcastPose broadcast_of(const LogText& text);
PoseEstimate estimate_of(const LogText& text);

}  // namespace sightline
