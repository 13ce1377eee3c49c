/// What estimators of robots that are localized by view are told over links: motions, sightings, and poses of those that are seen.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/motion_samples.hpp"
#include "bridges/dds/tag_subscriber.hpp"
#include "sightline/world/world.hpp"

namespace sightline::dds {

/// Where the frame that a robot's odometry is in lies in G, as the robot believes that it is.
/// @param odometry  of the robot, in its frame
/// @param age       of it: the heading turned on since [s]
/// @param believed  place and heading of the robot in G
LinkOrigin carried_frame(const Motion& odometry, double age, const Motion& estimated);
/// A command in G, in that frame.
Command in_local(const LinkOrigin& frame, const Command& command);

/// Of a fleet; none of it without a robot that is localized by view. Motions are those of the robots' own odometry. Bodies that are seen tell
/// their poses by what is measured of them, with the errors that [estimate.broadcast] says.
class LinkTelemetry {
 public:
  static constexpr std::size_t motions_most = 16;  ///< of a robot, in one period

  /// @param intake  of each robot by its odometry, in the order of the links; they outlive this
  /// @throws std::invalid_argument for a robot whose filter needs what no link tells, std::runtime_error where /tf cannot be had
  LinkTelemetry(const Scenario& scenario, const std::vector<PoseSubscriber*>& subscribers,
                dds_entity_t participant);

  bool empty() const noexcept { return robots_.empty(); }
  MeasuredMost most() const noexcept;
  /// Leaves out what came before the first period.
  void begin() noexcept;
  /// Adds what came since the last time; of the control thread, allocates nothing.
  /// @param origin  time 0, of the monotonic clock
  void measure(Nanoseconds origin, Measured& now) noexcept;

  /// None where nobody is localized by view.
  const TagSubscriber* tags() const { return tags_.get(); }

 private:
  struct Robot {
    BodyId body{};
    PoseSubscriber* odometry = nullptr;
    MotionSamples samples{};
  };
  struct TelemetryEmitter {
    BodyId body{};
    double last = 0.0;  // stamp of the last that it told [s]
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
