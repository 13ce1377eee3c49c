/// Where a body is: what it, or others about it, say, from the thread that receives to the control thread.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/conversion.hpp"
#include "bridges/dds/latency_monitor.hpp"
#include "bridges/dds/mailbox.hpp"
#include "bridges/dds/surroundings.hpp"
#include "bridges/dds/velocity_fit.hpp"
#include "sightline/run/spsc_queue.hpp"

namespace sightline::dds {

/// What a body did last.
struct SeenMotion {
  Motion motion{};        ///< in G
  Nanoseconds stamp = 0;  ///< when it was so, of the monotonic clock
};

/// Of a robot whose estimator goes by each of them, motions that wait: 0.6 s of 100 Hz.
inline constexpr std::size_t kept_motions = 64;

/// Of one body.
class PoseSubscriber {
 public:
  /// @param origin  of the frame that the messages are in
  explicit PoseSubscriber(const LinkOrigin& origin = {}) : origin_(origin) {}
  /// A reader whose messages are taken in, the first of all where there are several; it ends with the intake. Its messages may
  /// come at once.
  void read_by(std::unique_ptr<RawReader> reader) { readers_.push_back(std::move(reader)); }
  /// Says why nothing came of what the readers received, a few words; of any thread.
  void explain_by(std::function<std::string()> why_none) { why_none_ = std::move(why_none); }

  /// Keeps each motion until next() takes it, at most so many; before there is a reader.
  void keep_each(std::size_t most) { each_ = std::make_unique<SpscQueue<SeenMotion>>(most, SeenMotion{}); }

  // Of the thread that receives. Nothing is allocated.
  /// A motion in the local frame, with its time by the sender's clock; what is not finite or of another time is counted alone.
  void take(const Motion& local, Nanoseconds sampled, Nanoseconds arrived) noexcept;
  /// A pose alone: the velocity is fitted to the last of them.
  void take_pose(const Vec3<double>& p, const Quaternion& q, Nanoseconds sampled,
                 Nanoseconds arrived) noexcept;
  /// One that is not taken, for its time alone.
  void note(Nanoseconds sampled, Nanoseconds arrived) noexcept { latency_.note(sampled, arrived); }
  /// One in a frame, with a time, or of a writer that cannot be meant.
  void take_other_frame() noexcept { ++other_frame_; }
  void take_other_time() noexcept { ++other_time_; }
  void take_second_writer() noexcept { ++foreign_; }

  // Of the control thread.
  /// The newest motion. @return false where there was none yet
  bool look(SeenMotion& seen) noexcept;
  /// The newest, as of now; all zero where there was none.
  const SeenMotion& newest() noexcept;
  /// Whether there is one that is younger than that.
  bool is_fresh(Nanoseconds now, Nanoseconds old) noexcept {
    return now - newest().stamp < old && motion_.count() > 0;
  }

  /// The oldest that is kept. @return false where there is none
  bool next(SeenMotion& seen) noexcept;

  // Of any thread.
  /// The newest motion; all zero where there was none.
  SeenMotion last() const noexcept;
  bool in_other_frames() const noexcept { return other_frame_ > 0; }
  bool of_second_writer() const noexcept { return second_writer() > 0; }
  /// The least delay of the last 10 s, clocks' offset included.
  Nanoseconds least_delay() const noexcept { return least_delay_; }
  const RawReader& reader() const noexcept { return *readers_.front(); }
  const LatencyMonitor& arrivals() const noexcept { return latency_; }
  /// Adds what is found of them.
  /// @param frames        that they are in
  /// @param other_frames  what poses that count as of other frames are in
  void examine(std::string_view frames, std::string_view other_frames, FindingList& to) const;
  /// What was received and refused, in words.
  std::string counts() const;

 private:
  std::int64_t second_writer() const noexcept { return reader().counts().foreign + foreign_; }
  // Each counts one that is not.
  bool is_of_numbers(const Motion& motion) noexcept;
  bool is_of_our_time(Nanoseconds sampled, Nanoseconds arrived) noexcept;
  /// Of one that is.
  void put(const Motion& local, Nanoseconds sampled, Nanoseconds arrived) noexcept;

  LinkOrigin origin_;
  Mailbox<SeenMotion> motion_;                     // filled by the thread that receives
  std::unique_ptr<SpscQueue<SeenMotion>> each_{};  // likewise; none: the newest alone counts
  ClockOffset clock_;                              // of that thread
  VelocityFit fit_;                                // of that thread
  LatencyMonitor latency_;                         // filled by it
  std::atomic<Nanoseconds> least_delay_{0};
  std::atomic<std::int64_t> not_finite_{0}, other_time_{0}, other_frame_{0}, foreign_{0}, repeated_{0},
      jumps_{0};
  SeenMotion newest_{};  // of the control thread: for when the mailbox is being written
  std::function<std::string()> why_none_;
  std::vector<std::unique_ptr<RawReader>> readers_;  // last: they end before what they fill
};

}  // namespace sightline::dds
