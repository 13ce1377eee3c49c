/// The link to a robot that drives by cmd_vel and says where it is by an odometry, on plain topics of ROS 2.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/link_end.hpp"
#include "bridges/dds/mailbox.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

/// It has no arming: it is ours once it was asked, until it stands again. Such robots stop by themselves about 0.5 s after the last
/// cmd_vel.
class Ros2LinkEnd final : public LinkEnd {
 public:
  /// @throws std::runtime_error where a topic cannot be had
  Ros2LinkEnd(dds_entity_t participant, const Link& link);

  bool look(SeenMotion& seen) noexcept override;
  LinkFacts facts(Nanoseconds now) noexcept override;
  void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept override;
  void watch(std::span<const SeenWriter> writers) override;
  std::vector<std::string> obstacles(std::span<const SeenWriter> writers) override;
  std::string counts() const override;

 private:
  void on_odometry(const void* message, const Arrival& arrival);

  Ros2Link ros2_;
  LinkOrigin origin_;

  Mailbox<SeenMotion> motion_;  // filled by the thread that receives
  ClockOffset clock_;
  std::atomic<std::int64_t> not_finite_{0}, other_time_{0}, other_frame_{0};

  std::atomic<bool> heard_{false};  // by watch()
  std::atomic<int> rivals_{0};

  SeenMotion last_motion_{};  // of the control thread
  bool ours_ = false, stops_ = false;

  std::unique_ptr<RawWriter> cmd_vel_;
  std::unique_ptr<RawReader> odometry_;  // last: it ends before what it fills
};

}  // namespace sightline::dds
