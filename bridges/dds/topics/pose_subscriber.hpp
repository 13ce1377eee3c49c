/// Poses of a body, reported by itself or by others, from the receive thread to the control thread.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/dds/links/velocity_fit.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/conversion.hpp"
#include "bridges/dds/topics/delay_histogram.hpp"
#include "bridges/dds/topics/latency_monitor.hpp"
#include "bridges/dds/topics/mailbox.hpp"
#include "bridges/dds/topics/remote_clock.hpp"
#include "bridges/dds/topics/surroundings.hpp"
#include "sightline/loop.hpp"

namespace sightline::dds {

/// Last known motion of a body.
struct SeenMotion {
  Motion motion{};          ///< in G
  Nanoseconds stamp = 0;    ///< time of the motion, monotonic clock
  Nanoseconds sampled = 0;  ///< the same by the sender's clock
};

/// Queue length for robots whose estimator uses every motion: 0.6 s at 100 Hz.
inline constexpr std::size_t kept_motions = 64;

/// Poses of one body.
class PoseSubscriber {
 public:
  /// @param origin  of the frame that the messages are in
  explicit PoseSubscriber(const LinkOrigin& origin = {}) : origin_(origin) {}
  /// Adds a reader that feeds this subscriber and ends with it; the first reader is the main one.
  /// Messages may arrive during the call.
  void read_by(std::unique_ptr<RawReader> reader) { readers_.push_back(std::move(reader)); }
  /// Sets a function that explains why the received messages gave no pose, in a few words; any
  /// thread may call it.
  void explain_by(std::function<std::string()> why_none) { why_none_ = std::move(why_none); }

  /// Queues each motion until next() takes it, at most `most`; call it before read_by().
  void keep_each(std::size_t most) { each_ = std::make_unique<SpscQueue<SeenMotion>>(most, SeenMotion{}); }

  // Receive thread only. Nothing is allocated.
  /// Accepts a motion in the local frame, stamped by the sender's clock. Motions that are not
  /// finite or have an implausible time are only counted.
  void take(const Motion& local, Nanoseconds sampled, Nanoseconds arrived) noexcept {
    if (accepts(local, sampled, arrived)) put(local);
  }
  /// The two halves of take(), for a link that transforms a motion between them.
  bool accepts(const Motion& local, Nanoseconds sampled, Nanoseconds arrived) noexcept {
    return is_of_numbers(local) && is_of_our_time(sampled, arrived);
  }
  void put(const Motion& local) noexcept;
  /// Time of the last accepted motion, by the local clock.
  Nanoseconds stamp() const noexcept { return clock_.on_ours(); }
  /// Accepts a pose without velocity; the velocity is fitted to the recent poses.
  void take_pose(const Vec3<double>& p, const Quaternion& q, Nanoseconds sampled,
                 Nanoseconds arrived) noexcept;
  /// Count poses in another frame, with an implausible time, or of a second writer.
  void take_other_frame() noexcept { ++other_frame_; }
  void take_other_time() noexcept { ++other_time_; }
  void take_second_writer() noexcept { ++foreign_; }

  // Control thread only.
  /// Copies the newest motion. @return false if there is none yet
  bool look(SeenMotion& seen) noexcept;
  /// The newest motion at this time; all zero if there is none.
  const SeenMotion& newest() noexcept;
  /// Whether there is a motion younger than `old`.
  bool is_fresh(Nanoseconds now, Nanoseconds old) noexcept {
    return now - newest().stamp < old && motion_.count() > 0;
  }

  /// Takes the oldest queued motion. @return false if the queue is empty
  bool next(SeenMotion& seen) noexcept;

  // Any thread may call these.
  /// The newest motion; all zero if there is none.
  SeenMotion last() const noexcept;
  bool in_other_frames() const noexcept { return other_frame_ > 0; }
  bool of_second_writer() const noexcept { return second_writer() > 0; }
  /// Of the sender's clock: local time minus its time, less the delay of the fastest messages; rate
  /// of that offset [s/s]; number of its jumps.
  Nanoseconds clock_offset() const noexcept { return clock_offset_; }
  double clock_drift() const noexcept { return clock_drift_; }
  std::int64_t clock_jumps() const noexcept { return clock_jumps_; }
  const RawReader& reader() const noexcept { return *readers_.front(); }
  const LatencyMonitor& arrivals() const noexcept { return latency_; }
  /// Of all accepted poses: delay beyond that of the fastest, by the followed clock of the sender.
  const DelayHistogram& lateness() const noexcept { return lateness_; }
  /// Adds the findings about the poses.
  /// @param frames        expected frames, as text
  /// @param other_frames  text for the frames of poses that count as other frames
  void examine(std::string_view frames, std::string_view other_frames, FindingList& to) const;
  /// Counts of received and rejected messages, as text.
  std::string counts() const;

 private:
  std::int64_t second_writer() const noexcept { return reader().counts().foreign + foreign_; }
  // Each counts a motion that fails the check.
  bool is_of_numbers(const Motion& motion) noexcept;
  bool is_of_our_time(Nanoseconds sampled, Nanoseconds arrived) noexcept;

  LinkOrigin origin_;
  Mailbox<SeenMotion> motion_;                     // filled by the receive thread
  std::unique_ptr<SpscQueue<SeenMotion>> each_{};  // filled by the receive thread; null: newest motion only
  RemoteClock clock_;                              // receive thread only
  VelocityFit fit_;                                // receive thread only
  LatencyMonitor latency_;                         // filled by the receive thread
  DelayHistogram lateness_;                        // filled by the receive thread
  std::atomic<Nanoseconds> clock_offset_{0};
  std::atomic<double> clock_drift_{0.0};
  std::atomic<std::int64_t> clock_jumps_{0}, not_finite_{0}, other_time_{0}, other_frame_{0}, foreign_{0},
      repeated_{0}, jumps_{0};
  SeenMotion newest_{};  // control thread's copy, for reads that collide with a write
  std::function<std::string()> why_none_;
  std::vector<std::unique_ptr<RawReader>> readers_;  // last member: destroyed before the members they fill
};

}  // namespace sightline::dds
