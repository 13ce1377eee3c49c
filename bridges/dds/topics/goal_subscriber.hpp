/// Goals and paths that an operator sends to a robot, from the receive thread to the control
/// thread.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/mailbox.hpp"
#include "sightline/scenario.hpp"

namespace sightline::dds {

/// Bounds of admissible goals; infinite where unbounded.
struct GoalSpace {
  double world = std::numeric_limits<double>::infinity();    ///< maximum |p_x| and |p_y| [m]
  double floor = -std::numeric_limits<double>::infinity();   ///< minimum height [m]
  double ceiling = std::numeric_limits<double>::infinity();  ///< maximum height [m]
  std::vector<Zone> zones{};                                 ///< all are kept
};

/// Goals of one robot. A rejected message changes nothing.
class GoalSubscriber {
 public:
  /// Minimum time between two accepted messages [s]; of the messages in between, the last one is
  /// accepted.
  static constexpr double least_time = 0.1;

  /// @throws std::runtime_error if a topic cannot be created
  GoalSubscriber(dds_entity_t participant, const GoalsFrom& from, const GoalSpace& space);

  /// Control thread, each period: writes the newest message into the track, with time t. Allocates
  /// nothing.
  void pass_on(double t, GoalTrack& track) noexcept;
  /// Before a flight: discards all messages received so far.
  void forget() noexcept { passed_ = newest_.count(); }

  /// Single thread: one sentence for each rejection reason that occurs for the first time.
  std::vector<std::string> news();
  /// Counts of accepted and rejected messages, as text. Call it after the flight.
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
  void count_refusal(Refusal why) noexcept { ++refused_[static_cast<std::size_t>(why)]; }
  bool is_inside(const Vec3<double>& p) const noexcept;
  void offer(const Message& message) noexcept;
  std::string describe(Refusal why) const;

  GoalsFrom from_;
  GoalSpace space_;
  std::mutex puts_;  // the receive threads, one per topic
  Mailbox<Message> newest_;
  std::array<std::atomic<std::int64_t>, refusals> refused_{};
  std::atomic<std::int64_t> taken_{0};
  std::array<std::int64_t, refusals> reported_{};  // used by news()
  Message message_{};                              // control thread only, as the members below
  std::uint64_t passed_ = 0;
  double passed_at_ = -1.0;
  std::unique_ptr<RawReader> goal_, path_;  // last member: destroyed before the members they fill
};

}  // namespace sightline::dds
