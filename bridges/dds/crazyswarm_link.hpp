/// The link to a Crazyflie behind the server of Crazyswarm2.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/link_end.hpp"
#include "bridges/dds/mailbox.hpp"
#include "bridges/dds/pose_subscriber.hpp"
#include "bridges/dds/service.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

/// Bits of supervisor_info, as the firmware has them.
enum SupervisorBit : std::uint16_t {
  can_be_armed = 1,
  is_armed = 2,
  arms_itself = 4,  ///< the firmware, where its checks pass: of Crazyflies with brushed motors
  can_fly = 8,
  is_flying = 16,  ///< until 2 s after the motors last lifted
  is_tumbled = 32,
  is_locked = 64,
  is_crashed = 128,
};
/// pm_state, of which all but this one is no state to fly in: charging, charged, low, shutting down.
inline constexpr std::uint8_t on_battery = 0;
inline constexpr std::uint8_t battery_low = 3;

/// A Crazyflie has no modes and asks nobody who steers it: whatever is sent to it last counts. So what it is at is what it was asked
/// for, as far as its status agrees. Set-points lock out its commander for take-off and landing until they are said to have ended.
class CrazyswarmLinkEnd final : public LinkEnd {
 public:
  /// @throws std::runtime_error where a topic cannot be had
  CrazyswarmLinkEnd(Port participant, const Link& link);

  bool look(SeenMotion& seen) noexcept override { return poses_.look(seen); }
  LinkFacts facts(Nanoseconds now) noexcept override;
  void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept override;
  void watch(std::span<const SeenWriter> writers) override;
  void examine(const Surroundings& around, FindingList& to) override;
  PoseSubscriber& subscriber() noexcept override { return poses_; }
  std::string counts() const override;

 private:
  struct Status {
    Nanoseconds arrived = 0;
    std::uint16_t supervisor = 0;
    std::uint8_t pm_state = 0;
    float voltage = 0.0F;
  };
  enum class Phase : std::uint8_t { ground, arming, takeoff, setpoints, landing };
  /// Of a landing: first the set-points end, then it lands.
  enum class Landing : std::uint8_t { none, setpoints_end, requested };

  bool has(SupervisorBit bit) const noexcept { return (last_status_.supervisor & bit) != 0; }
  bool battery_is_good() const noexcept {
    return last_status_.pm_state == on_battery && last_status_.voltage >= crazyflie_.battery_min;
  }
  double height() noexcept { return poses_.newest().motion.p.z - origin_.p.z; }
  void examine_battery(FindingList& to) const;
  void request(Request request, Nanoseconds now) noexcept;
  void go_on_landing(Nanoseconds now) noexcept;
  void send_state(const TrajectoryPoint& point) noexcept;

  Crazyswarm2Link crazyflie_;
  PosesFrom from_;
  LinkOrigin origin_;

  Mailbox<Status> status_;  // filled by the thread that receives

  std::atomic<bool> received_{false};  // by watch()
  std::atomic<int> rivals_{0};
  int looks_ = 0;

  // Of the control thread.
  Status last_status_{};
  Phase phase_ = Phase::ground;
  Landing landing_ = Landing::none;
  Nanoseconds requested_at_ = 0;
  double land_from_ = 0.0;  // its height when it was to land [m]
  bool holds_ = false, down_ = false, disarms_ = false;
  TrajectoryPoint hold_{};  // where it was when it was to hold
  int speakers_ = -1;       // that had come when it was asked to arm; -1: it was not yet

  std::unique_ptr<RawWriter> full_state_;
  ServiceCaller takeoff_, land_, arm_, setpoints_stop_, emergency_;
  PoseSubscriber poses_;
  std::unique_ptr<RawReader> status_reader_;  // last: it ends before what it fills
};

}  // namespace sightline::dds
