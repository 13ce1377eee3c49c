/// Where a person sends a robot: goals and paths from topics, from the thread that receives to the control thread.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/mailbox.hpp"
#include "sightline/scenario/goal_track.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

/// Where goals may lie; infinite where nothing bounds them.
struct GoalSpace {
  double world = std::numeric_limits<double>::infinity();    ///< greatest |p_x| and |p_y| [m]
  double floor = -std::numeric_limits<double>::infinity();   ///< least height [m]
  double ceiling = std::numeric_limits<double>::infinity();  ///< greatest height [m]
};

/// Of one robot. What is refused changes nothing.
class GoalSubscriber {
 public:
  /// The least time between two messages that are taken; of those between, the last is [s].
  static constexpr double least_time = 0.1;

  /// @throws std::runtime_error where a topic cannot be had
  GoalSubscriber(dds_entity_t participant, const GoalsFrom& from, const GoalSpace& space);

  /// By the control thread, each period: puts the newest message into the track, as of now. Allocates nothing.
  void pass_on(double t, GoalTrack& track) noexcept;
  /// Before a flight: what came until now does not count.
  void forget() noexcept { passed_ = newest_.count(); }

  /// By one thread: what was refused for a reason that was not told yet, a sentence each.
  std::vector<std::string> news();
  /// What was received and refused, in words. After the flight.
  std::string counts() const;

 private:
  enum class Refusal { not_finite, frame, outside, times, length, too_fast, full };
  static constexpr std::size_t refusals = 7;
  struct Message {
    std::size_t count = 0;
    std::array<Waypoint, GoalTrack::path_most> waypoints{};
  };

  void on_goal(const void* message);
  void on_path(const void* message);
  void throw_invalid(Refusal why) noexcept { ++refused_[static_cast<std::size_t>(why)]; }
  bool is_inside(const Vec3<double>& p) const noexcept;
  void offer(const Message& message) noexcept;
  std::string describe(Refusal why) const;

  GoalsFrom from_;
  GoalSpace space_;
  std::mutex puts_;  // of the threads that receive, one for each topic
  Mailbox<Message> newest_;
  std::array<std::atomic<std::int64_t>, refusals> refused_{};
  std::atomic<std::int64_t> taken_{0};
  std::array<std::int64_t, refusals> received_{};  // by news()
  Message message_{};                              // of the control thread, as what follows
  std::uint64_t passed_ = 0;
  double passed_at_ = -1.0;
  std::unique_ptr<RawReader> goal_, path_;  // last: they end before what they fill
};

}  // namespace sightline::dds
