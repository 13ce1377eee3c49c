/// The link to a robot that drives by cmd_vel and says where it is by an odometry, on plain topics of ROS 2.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/link_end.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

/// It has no arming: it is ours once it was asked, until it stands again. Such robots stop by themselves about 0.5 s after the last
/// cmd_vel.
class Ros2LinkEnd : public LinkEnd {
 public:
  /// @throws std::runtime_error where a topic cannot be had
  Ros2LinkEnd(Port participant, const Link& link);

  bool look(SeenMotion& seen) noexcept final { return poses_.look(seen); }
  LinkFacts facts(Nanoseconds now) noexcept override;
  void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept override;
  void watch(std::span<const SeenWriter> writers) override;
  void examine(const Surroundings& around, FindingList& to) override;
  PoseSubscriber& subscriber() noexcept override { return poses_; }
  std::string counts() const override { return poses_.counts(); }

 protected:
  /// Sends a velocity, forward, to the left and up, and a rate of the heading: all that a Twist has room for, in its own units.
  void steer(const Vec3<double>& v, double r) noexcept;
  const Ros2Link& link() const { return ros2_; }
  const Motion& motion() noexcept { return poses_.newest().motion; }

 private:
  void on_odometry(const void* message, const Arrival& arrival);

  Ros2Link ros2_;
  PosesFrom from_;

  std::atomic<bool> received_{false};  // by watch()
  std::atomic<int> rivals_{0};

  bool ours_ = false, stops_ = false;  // of the control thread

  std::unique_ptr<RawWriter> cmd_vel_;
  PoseSubscriber poses_;
};

}  // namespace sightline::dds
