/// Estimator inputs of vision-localized robots over links: odometry, detections, and broadcast
/// poses of observed bodies.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/links/link_end.hpp"
#include "bridges/dds/links/motion_samples.hpp"
#include "bridges/dds/topics/tag_subscriber.hpp"
#include "sightline/world.hpp"

namespace sightline::dds {

/// Pose in G of the robot's odometry frame, according to its pose estimate.
/// @param odometry   of the robot, in its odometry frame
/// @param age        of the odometry [s]; the heading is extrapolated by its rate
/// @param estimated  position and heading of the robot in G
LinkOrigin carried_frame(const Motion& odometry, double age, const Motion& estimated);
/// A command in G, expressed in that frame.
Command in_local(const LinkOrigin& frame, const Command& command);

/// Whether a robot's pose is estimated by the attitude filter.
bool uses_attitude_filter(const Scenario& scenario, BodyId robot);

/// Telemetry of a fleet; empty without a vision-localized robot. Motions come from the robots' own
/// odometry; for the attitude filter also from their IMUs, without which there is no motion.
/// Observed bodies broadcast their measured poses, with the error model of [estimate.broadcast].
class LinkTelemetry {
 public:
  static constexpr std::size_t motions_most = 16;  ///< per robot and period

  /// @param ends  of each robot, in link order; must outlive this
  /// @throws std::invalid_argument if a robot's filter needs an input that no link provides,
  ///   std::runtime_error if /tf cannot be read
  LinkTelemetry(const Scenario& scenario, const std::vector<LinkEnd*>& ends, dds_entity_t participant);

  bool empty() const noexcept { return robots_.empty(); }
  MeasuredMost most() const noexcept;
  /// Discards everything that arrived before the first period.
  void begin() noexcept;
  /// Adds everything that arrived since the last call; control thread, allocates nothing.
  /// @param origin  time 0, of the monotonic clock
  void measure(Nanoseconds origin, Measured& now) noexcept;

  /// Null if no robot is localized by vision.
  const TagSubscriber* tags() const { return tags_.get(); }

 private:
  struct Robot {
    BodyId body{};
    PoseSubscriber* odometry = nullptr;
    InertialSamples* inertial = nullptr;  // of the attitude filter alone
    MotionSamples samples{};
  };
  struct TelemetryEmitter {
    BodyId body{};
    double last = 0.0;  // stamp of the last broadcast [s]
    bool reported = false;
  };

  Team team_;
  Radio radio_;
  std::vector<Robot> robots_;
  std::vector<TelemetryEmitter> emitters_;
  std::vector<RobotMotion> motions_;
  std::vector<BodyBroadcast> broadcasts_;
  std::vector<double> rest_;
  std::unique_ptr<TagSubscriber> tags_;
};

}  // namespace sightline::dds
