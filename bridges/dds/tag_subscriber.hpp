/// What the cameras of robots see of others, as apriltag_ros says it on /tf.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/link_end.hpp"
#include "sightline/run/spsc_queue.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/world/detection.hpp"

namespace sightline::dds {

/// A camera whose pictures are searched by somebody else.
struct WatchedCamera {
  RobotCamera camera{};
  const PoseSubscriber* own = nullptr;  ///< of its robot's odometry, by which it leans; outlives the intake
};

/// A message of apriltag_ros is a picture: transforms from the camera's optical frame to the tags that were found in it, with the time of
/// the exposure. All tags of one body give one pose: the one that fits best to where their corners are in the picture, with the covariance
/// that the noise model of detections has for it (docs/localization.md). Stamps are of our real-time clock.
///
/// Counted and left out: what is not finite or no unit quaternion; tags that no body has; a time more than 5 ms ahead of ours or 1 s old; a
/// picture that was there already; a second writer of the same camera; tags that do not fit to one body; what finds no room.
class TagSubscriber {
 public:
  static constexpr std::size_t room = 256;                     ///< detections that wait
  static constexpr std::size_t most = 64;                      ///< that one period takes
  static constexpr double ahead_most = 0.005, age_most = 1.0;  ///< of a time stamp [s]
  static constexpr double misfit_most = 3.0;                   ///< of corners [px]

  /// @throws std::runtime_error where /tf cannot be had
  TagSubscriber(const Scenario& scenario, const std::vector<WatchedCamera>& cameras,
                dds_entity_t participant);
  TagSubscriber(const TagSubscriber&) = delete;  // its reader points into it
  TagSubscriber& operator=(const TagSubscriber&) = delete;

  /// Of the control thread: what came since the last time, in the order of arrival. Valid until the next call.
  /// @param origin  time 0 of the stamps, of the monotonic clock
  std::span<const Detection> take(Nanoseconds origin) noexcept;
  /// Of the control thread: leaves out what waits.
  void forget() noexcept;

  /// Adds what is found of a robot's camera; by the thread that looks around.
  void examine(BodyId robot, const Surroundings& around, FindingList& to) const;
  /// Of a robot's camera, what was received and refused, in words.
  std::string counts(BodyId robot) const;

 private:
  struct Seen {
    Detection detection{};
    Nanoseconds stamp = 0, arrived = 0;  // of the monotonic clock
  };
  struct Eye {
    explicit Eye(const WatchedCamera& one) : of(one) {}

    WatchedCamera of;
    LatencyMonitor arrivals{};
    std::atomic<std::int64_t> pictures{0}, garbled{0}, other_tags{0}, ahead{0}, old{0}, repeated{0},
        foreign{0}, misfits{0}, lost{0};
    // Of the thread that receives.
    std::uint64_t writer = 0;
    std::array<Nanoseconds, 64> stamps{};  // of the last pictures, a ring
    std::size_t next = 0;
  };

  void on_transforms(const void* message, const Arrival& arrival) noexcept;
  /// Of one picture: which of the tags found are of which body.
  void look(Eye& eye, const void* message, Nanoseconds stamp, Nanoseconds arrived) noexcept;
  bool is_new(Eye& eye, Nanoseconds stamp) const noexcept;
  const Eye* eye_of(BodyId robot) const;

  CameraOptions vision_;
  std::deque<Eye> eyes_;
  SpscQueue<Seen> ring_;
  std::vector<Detection> taken_;
  std::unique_ptr<RawReader> reader_;  // last: it ends before what it fills
};

}  // namespace sightline::dds
