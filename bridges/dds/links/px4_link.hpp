/// Link to a PX4 vehicle behind its uXRCE-DDS agent, releases 1.14 to 1.18.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/links/frame_anchor.hpp"
#include "bridges/dds/links/link_end.hpp"
#include "bridges/dds/links/px4_diagnostics.hpp"
#include "bridges/dds/links/px4_release.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/mailbox.hpp"

namespace sightline::dds {

// PX4's values of states and commands.
enum class NavState : std::uint8_t { position = 2, hold = 4, takeoff = 17, land = 18, offboard = 14 };
inline constexpr std::uint8_t px4_disarmed = 1, px4_armed = 2;
enum class Px4Command : std::uint32_t {
  land = 21,
  takeoff = 22,
  set_mode = 176,
  arm_disarm = 400,
  set_origin = 100000
};
inline constexpr float px4_custom_mode = 1.0F, px4_mode_offboard = 6.0F, px4_mode_auto = 4.0F,
                       px4_auto_loiter = 3.0F;
inline constexpr float px4_force = 21196.0F;  // param2 of arm_disarm: also in the air
inline constexpr std::uint8_t px4_frame_ned = 1, px4_velocity_body = 3;
inline constexpr std::uint8_t px4_battery_good = 0, px4_battery_critical = 2;  // BatteryStatus.warning

/// accelerometer_timestamp_relative of a SensorCombined without an acceleration.
inline constexpr std::int32_t px4_no_acceleration = std::numeric_limits<std::int32_t>::max();

/// Stamp of sent set-points: none, or that of the pose that each answers.
enum class Stamps { none, of_poses };

class Px4LinkEnd final : public LinkEnd {
 public:
  /// @param stamps  of_poses if the agent runs on this machine
  /// @param height  where the task begins, in G [m]
  /// @throws std::runtime_error if a topic cannot be created
  Px4LinkEnd(Port participant, const Link& link, Stamps stamps, double height, Inertial inertial);
  ~Px4LinkEnd() override;

  bool look(SeenMotion& seen) noexcept override;
  LinkFacts facts(Nanoseconds now) noexcept override;
  void send(const LinkOutput& output, const Command& command, Nanoseconds now) noexcept override;
  void watch(std::span<const SeenWriter> writers) override;
  void examine(const Surroundings& around, FindingList& to) override;
  PoseSubscriber& subscriber() noexcept override { return poses(); }
  InertialSamples* inertial() noexcept override { return inertial_.get(); }
  std::optional<GeoPoint> reference() const override;
  void stop_examining() override { aside_.reset(); }
  std::string reply() override;
  std::string counts() const override;
  double stamps_behind() const noexcept override {
    return aside_ && from_.source == PoseSource::odometry ? aside_->stamps_behind() : 0.0;
  }

 private:
  struct Status {
    Nanoseconds arrived = 0;
    std::uint8_t arming = 0, nav = 0, system = 0;
    bool failsafe = false, preflight = false;
  };
  struct Position {
    Nanoseconds arrived = 0;
    std::array<bool, 4> valid{};  // in the order of valid_names
    bool global = false;
    GeoPoint reference{};

    bool good() const noexcept { return std::find(valid.begin(), valid.end(), false) == valid.end(); }
  };
  static constexpr std::array<std::string_view, 4> valid_names = {"xy", "z", "v_xy", "v_z"};
  /// Alignment of the vehicle's estimator; true for all if it does not report any.
  struct Alignment {
    Nanoseconds arrived = 0;
    bool tilt = true, heading = true;
  };
  struct Landed {
    Nanoseconds arrived = 0;
    bool landed = false;
  };
  struct Ack {
    Nanoseconds arrived = 0;
    std::uint32_t command = 0;
    std::uint8_t result = 0, system = 0;  // system: that of the request
  };
  /// Newest pose in its own local frame, ENU.
  struct OwnPose {
    Vec3<double> p{};           // [m]
    std::uint64_t sampled = 0;  // by the vehicle's clock [us]
  };
  struct Ends;

  void read_state(dds_entity_t participant);
  void read_poses(dds_entity_t participant);
  void read_inertial(dds_entity_t participant);
  bool has_valid_estimate() const noexcept;
  LinkReason unfit(const Vec3<double>& p) const noexcept;
  void on_odometry(const void* message, const Arrival& arrival);
  PoseSubscriber& poses() noexcept { return seen_ ? *seen_ : odometry_; }
  const PoseSubscriber& poses() const noexcept { return seen_ ? *seen_ : odometry_; }
  double turned_from_seen() noexcept;
  bool is_seen_well() noexcept;
  void examine_topics(const Surroundings& around, FindingList& to) const;
  void examine_writers(const Surroundings& around, FindingList& to) const;
  void examine_estimator(FindingList& to) const;
  void examine_state(FindingList& to);
  bool is_in(NavState nav) const noexcept { return last_status_.nav == static_cast<std::uint8_t>(nav); }
  std::string failing() const;
  /// Position, velocity and acceleration in the vehicle's own local frame, ENU. The place is that of the
  /// vehicle's own pose plus the way from the pose in G, whatever frames are between.
  TrajectoryPoint in_own_frame(const TrajectoryPoint& to) const noexcept;
  void command(Px4Command which, const std::array<float, 3>& params) noexcept;

  Px4Link px4_;
  PosesFrom from_;
  LinkOrigin origin_;
  int release_;
  Stamps stamps_;
  double height_;

  // Filled by the receive thread.
  Mailbox<Status> status_;
  Mailbox<Position> position_;
  Mailbox<Alignment> alignment_;
  Mailbox<Landed> landed_;
  Mailbox<Px4Battery> battery_;
  Mailbox<Ack> ack_;
  Mailbox<OwnPose> own_;
  FrameAnchor anchor_;

  std::atomic<bool> says_offboard_{false};  // according to the newest status

  // Set by watch().
  std::atomic<bool> received_{false};  // the vehicle's reader is matched with our writers
  std::atomic<int> rivals_{0};

  // Control thread: last values, for reads that collide with a write.
  Status last_status_{};
  Position last_position_{};
  Alignment last_alignment_{};
  Landed last_landed_{};
  Px4Battery last_battery_{};
  Ack last_ack_{};
  Request requested_ = Request::none;  // the last, sent since requested_at_
  Request replied_ = Request::none;    // that of the last reply; none: reported
  Px4Command requested_by_{};
  Nanoseconds requested_at_ = 0, replied_at_ = 0, beat_at_ = 0;
  OwnPose answered_{};                                // own_ at the pose that the next command answers
  Vec3<double> answered_at_{};                        // position of that pose, in G [m]
  std::atomic<std::int64_t> sent_{0}, held_back_{0};  // set-points
  Vec3<double> left_{};                               // position at the arm request
  bool rises_ = false;                                // from the arm request until the task
  int speakers_ = -1;  // status writers matched at the arm request; -1: none requested yet

  PoseSubscriber odometry_;
  std::unique_ptr<PoseSubscriber> seen_;       // poses from others, if the link uses them
  std::unique_ptr<InertialSamples> inertial_;  // if the pose estimator uses them
  std::unique_ptr<Px4Diagnostics> aside_;      // until arming
  std::unique_ptr<Ends> ends_;                 // last member: readers end before the members they fill
};

}  // namespace sightline::dds
