/// Link to a Crazyflie behind the Crazyswarm2 server.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/links/link_end.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/mailbox.hpp"
#include "bridges/dds/topics/pose_subscriber.hpp"
#include "bridges/dds/topics/service.hpp"

namespace sightline::dds {

/// Bits of supervisor_info, as in the firmware.
enum SupervisorBit : std::uint16_t {
  can_be_armed = 1,
  is_armed = 2,
  arms_itself = 4,  ///< the firmware arms itself after its checks: Crazyflies with brushed motors
  can_fly = 8,
  is_flying = 16,  ///< until 2 s after the motors last lifted
  is_tumbled = 32,
  is_locked = 64,
  is_crashed = 128,
  planner_flies = 256,    ///< its planner takes off, lands, or holds; newer firmware
  planner_is_done = 512,  ///< the planned motion has ended, or there is none
};
/// Values of pm_state. Flight is allowed only in on_battery; the others are charging, charged, low,
/// shutting down.
inline constexpr std::uint8_t on_battery = 0;
inline constexpr std::uint8_t battery_low = 3;

/// Periods from one set-point to the next, so that set-points take at most 0.9 of the packets that
/// the radio carries. At most 0.1 s: the firmware levels out after 0.5 s.
///
/// The server fills the radio with empty packets, so their rate is what the radio carries. It sends
/// set-points before requests to land: on a full radio these never leave.
/// @param latency  of a unicast packet [ms], which counts if the rate is unknown; 0: unknown
/// @param rate     of unicast packets that arrive [1/s]; 0: unknown
/// @param period   [s]
int periods_of_setpoint(int latency, double rate, double period) noexcept;

/// The same in flight: the number only rises, and beyond need, so that packets which wait drain.
/// @param each  the present number
int periods_of_setpoint_in_flight(int each, double rate, double period) noexcept;

/// Whether poses arrive late, since the logs of a Crazyflie wait for packets that they answer. The
/// server stamps them as they arrive, so their stamps do not tell.
/// @param latency  of a unicast packet [ms]; it includes the logs that wait
/// @param packets  that arrived at the Crazyflie lately
/// @param logs     that it sent meanwhile; as many as packets: more wait
bool poses_are_late(int latency, double packets, double logs) noexcept;

/// A Crazyflie has no flight modes and no exclusive controller: the last command received is in
/// force. The mode is therefore the last requested one, if the status agrees.
/// Set-points lock out the take-off and landing commander until a request ends them.
///
/// The radio serves its Crazyflies in turns. On the ground the rate of set-points follows what the
/// server reports of the radio. In flight it only falls, since a lower latency may be the effect of
/// fewer set-points.
class CrazyswarmLinkEnd final : public LinkEnd {
 public:
  /// @param period  between two calls of send() [s]
  /// @throws std::runtime_error if a topic cannot be created
  CrazyswarmLinkEnd(Port participant, const Link& link, double period, Inertial inertial);

  bool look(SeenMotion& seen) noexcept override { return poses_.look(seen); }
  LinkFacts facts(Nanoseconds now) noexcept override;
  void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept override;
  void watch(std::span<const SeenWriter> writers) override;
  void examine(const Surroundings& around, FindingList& to) override;
  PoseSubscriber& subscriber() noexcept override { return poses_; }
  InertialSamples* inertial() noexcept override { return inertial_.get(); }
  std::string counts() const override;

 private:
  struct Status {
    Nanoseconds arrived = 0;
    std::uint16_t supervisor = 0;
    std::uint8_t pm_state = 0;
    float voltage = 0.0F;
    int latency = 0;    // of a unicast packet [ms]; 0: unknown
    double rate = 0.0;  // of unicast packets that arrive, mean of the last 0.3 s [1/s]
    // Unicast packets since the first status; received: 0 if the firmware does not count them.
    Nanoseconds first = 0;
    std::int64_t sent = 0, received = 0;
    // Packets that arrived, and logs that came with them, in the last second or so.
    double packets_lately = 0, logs_lately = 0;
    std::int64_t others = 0;  // other logs until then
  };
  enum class Phase : std::uint8_t { ground, arming, takeoff, setpoints, landing };
  /// Landing sequence. The firmware stops its motors if set-points end before it has a plan, and a
  /// late set-point stops the plan: so land, end the set-points, and land once more.
  enum class Landing : std::uint8_t { none, last_setpoint, planned, setpoints_end, requested };

  bool has(SupervisorBit bit) const noexcept { return (last_status_.supervisor & bit) != 0; }
  bool battery_is_good() const noexcept {
    return last_status_.pm_state == on_battery && last_status_.voltage >= crazyflie_.battery_min;
  }
  double height() noexcept { return poses_.newest().motion.p.z - origin_.p.z; }
  bool are_poses_late() const noexcept;
  bool lands() noexcept;
  bool is_up() noexcept;
  double turned() noexcept;
  LinkReason unfit() noexcept;
  void on_status(const void* message, Nanoseconds arrived);
  void read_inertial(Port participant);
  void examine_battery(FindingList& to) const;
  void examine_radio(FindingList& to) const;
  void request(Request request, Nanoseconds now) noexcept;
  void turn_back(Nanoseconds now) noexcept;
  void go_on_landing(Nanoseconds now) noexcept;
  void land() noexcept;
  void send_state(const TrajectoryPoint& point) noexcept;

  Crazyswarm2Link crazyflie_;
  PosesFrom from_;
  LinkOrigin origin_;
  double period_;  // [s]

  // Receive thread.
  Status taken_{};
  Mailbox<Status> status_;

  std::atomic<bool> received_{false};  // set by watch()
  std::atomic<int> rivals_{0};
  int looks_ = 0;

  // Control thread only.
  Status last_status_{};
  Phase phase_ = Phase::ground;
  Landing landing_ = Landing::none;
  Nanoseconds requested_at_ = 0;
  Nanoseconds landing_since_ = 0;  // of the step of the landing sequence
  double land_from_ = 0.0;         // height at the landing request [m]
  Nanoseconds may_fly_since_ = 0;  // first status with which it may fly; 0: it may not
  Motion left_{};                  // where it was armed
  bool turns_back_ = false;        // hovers after its take-off, at another heading
  int turns_ = 0;                  // requests to turn back
  Nanoseconds turned_at_ = 0;      // end of the last one
  bool tells_planner_ = false;     // its status has planner_flies
  bool holds_ = false, down_ = false, disarms_ = false;
  std::atomic<int> each_{1};  // periods from one set-point to the next; any thread reads it
  int wait_ = 0;              // periods until the next one
  TrajectoryPoint hold_{};    // pose at the hold request
  int speakers_ = -1;         // status writers matched at the arm request; -1: none requested yet

  std::unique_ptr<RawWriter> full_state_;
  ServiceCaller takeoff_, land_, go_to_, arm_, setpoints_stop_, emergency_;
  PoseSubscriber poses_;
  std::unique_ptr<InertialSamples> inertial_;  // if the pose estimator uses them
  std::atomic<std::int64_t> other_logs_{0};    // of its IMU, with another number of values
  std::unique_ptr<RawReader> inertial_reader_;
  std::unique_ptr<RawReader> status_reader_;  // last member: destroyed before the members it fills
};

}  // namespace sightline::dds
