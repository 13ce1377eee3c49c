/// Link to a robot that is driven by cmd_vel and reports odometry, on plain ROS 2 topics.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/links/link_end.hpp"
#include "bridges/dds/topics/channel.hpp"

namespace sightline::dds {

/// The link has no arming: the robot is in our control from the first request until it stands
/// again. Such robots stop about 0.5 s after the last cmd_vel.
class Ros2LinkEnd : public LinkEnd {
 public:
  /// @throws std::runtime_error if a topic cannot be created
  Ros2LinkEnd(Port participant, const Link& link);

  bool look(SeenMotion& seen) noexcept final { return poses_.look(seen); }
  LinkFacts facts(Nanoseconds now) noexcept override;
  void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept override;
  void watch(std::span<const SeenWriter> writers) override;
  void examine(const Surroundings& around, FindingList& to) override;
  PoseSubscriber& subscriber() noexcept override { return poses_; }
  std::string counts() const override { return poses_.counts(); }

 protected:
  /// Sends a velocity (forward, left, up) and a heading rate: the components of a Twist, in the
  /// units of the link.
  void steer(const Vec3<double>& v, double r) noexcept;
  const Ros2Link& link() const { return ros2_; }
  const Motion& motion() noexcept { return poses_.newest().motion; }

 private:
  void on_odometry(const void* message, const Arrival& arrival);

  Ros2Link ros2_;
  PosesFrom from_;

  std::atomic<bool> received_{false};  // set by watch()
  std::atomic<int> rivals_{0};

  bool ours_ = false, stops_ = false;  // control thread only

  std::unique_ptr<RawWriter> cmd_vel_;
  PoseSubscriber poses_;
};

}  // namespace sightline::dds
