/// Camera detections of other robots, from the /tf messages of apriltag_ros.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/links/link_end.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"
#include "sightline/world.hpp"

namespace sightline::dds {

/// A camera whose images an external detector processes.
struct WatchedCamera {
  RobotCamera camera{};
  const PoseSubscriber* own = nullptr;  ///< its robot's odometry, for the tilt; must outlive the subscriber
};

/// Each apriltag_ros message is one image: transforms from the camera's optical frame to the
/// detected tags, stamped with the exposure time by our real-time clock.
/// All tags of one body give one pose: the best fit to their corners in the image. Its covariance
/// follows from the detection noise model (docs/localization.md).
///
/// Counted and rejected:
/// - values that are not finite, quaternions not of unit length, tags of no body;
/// - stamps more than 5 ms ahead or 1 s old, repeated images, a second writer for the same camera;
/// - tags that do not fit one body, and detections beyond the queue size.
class TagSubscriber {
 public:
  static constexpr std::size_t room = 256;                     ///< queued detections
  static constexpr std::size_t most = 64;                      ///< detections per period
  static constexpr double ahead_most = 0.005, age_most = 1.0;  ///< of a stamp [s]
  static constexpr double misfit_most = 3.0;                   ///< rms corner error [px]

  /// @throws std::runtime_error if /tf cannot be read
  TagSubscriber(const Scenario& scenario, const std::vector<WatchedCamera>& cameras,
                dds_entity_t participant);
  TagSubscriber(const TagSubscriber&) = delete;  // its reader holds a pointer to it
  TagSubscriber& operator=(const TagSubscriber&) = delete;

  /// Control thread: detections since the last call, in order of arrival. Valid until the next
  /// call.
  /// @param origin  time 0 of the stamps, of the monotonic clock
  std::span<const Detection> take(Nanoseconds origin) noexcept;
  /// Control thread: discards the queued detections.
  void forget() noexcept;

  /// Adds the findings about a robot's camera; called by the examining thread.
  void examine(BodyId robot, const Surroundings& around, FindingList& to) const;
  /// Counts of received and rejected detections of a robot's camera, as text.
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
    // Receive thread only.
    std::uint64_t writer = 0;
    std::array<Nanoseconds, 64> stamps{};  // of the last images, ring buffer
    std::size_t next = 0;
  };

  void on_transforms(const void* message, const Arrival& arrival) noexcept;
  /// Processes one image: assigns the detected tags to bodies.
  void look(Eye& eye, const void* message, Nanoseconds stamp, Nanoseconds arrived) noexcept;
  bool is_new(Eye& eye, Nanoseconds stamp) const noexcept;
  const Eye* eye_of(BodyId robot) const;

  CameraOptions vision_;
  std::deque<Eye> eyes_;
  SpscQueue<Seen> ring_;
  std::vector<Detection> taken_;
  std::unique_ptr<RawReader> reader_;  // last member: destroyed before the members it fills
};

}  // namespace sightline::dds
