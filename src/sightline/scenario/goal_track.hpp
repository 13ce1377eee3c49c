/// Goals and paths that a user sends to a robot in flight, as one continuous reference.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "sightline/ocp/team.hpp"
#include "sightline/potential/reference.hpp"

namespace sightline {

/// A place on a robot's path.
struct Waypoint {
  double after =
      0.0;  ///< time of arrival after the message [s]; 0 for a single waypoint: at the track's own speed
  Vec3<double> p{};      ///< [m], in G
  double heading = 0.0;  ///< [rad]
};

/// Result of a message.
enum class GoalAnswer { taken, too_fast, full };

/// A reference that begins as the robot's own and then follows messages.
///
/// A message at time t leads from the present reference, with its velocity, to the goal. Each leg
/// is the cubic with these ends,
///
///   x*(s) = (2s^3 - 3s^2 + 1) p_0 + (s^3 - 2s^2 + s) T v_0 + (3s^2 - 2s^3) p_1 + (s^3 - s^2) T v_1,
///   s = (time - begin) / T
///
/// which from rest to rest is the blend s^2 (3 - 2 s) of events. A goal has T = 1.5 distance /
/// speed, the time at which the blend's greatest speed is `speed`. T is at least 1 s and 1.5 angle
/// / (1 rad/s). The legs of a path are straight lines, except the first, which meets the velocity
/// of the second. Headings turn the shorter way, by the blend.
///
/// x*(time) depends only on messages up to that time: a log and a replay reproduce the controller's
/// reference. One thread adds messages; any thread may read.
class GoalTrack {
 public:
  static constexpr std::size_t path_most = 64;                                   ///< waypoints of a message
  static constexpr std::size_t messages_most = 16'384, legs_most = 32'768;       ///< of a flight
  static constexpr double least_time = 1.0, turn_speed = 1.0, path_speed = 5.0;  ///< [s], [rad/s], [m/s]

  /// @param own    reference until the first message
  /// @param speed  towards goals [m/s], > 0
  GoalTrack(Model model, Reference own, double speed);

  /// Removes all messages: before a flight.
  void clear() noexcept { messages_.count = 0; }

  /// Adds a message at time t of the flight [s], later than the previous one, with 1 to path_most
  /// waypoints; those of a path have rising times. Allocates nothing.
  GoalAnswer add(double t, std::span<const Waypoint> waypoints) noexcept;

  /// Messages so far. Thread-safe.
  std::size_t messages() const noexcept { return messages_.count.load(std::memory_order_acquire); }
  /// Time of a message [s].
  double time(std::size_t message) const noexcept { return messages_.list[message].t; }
  /// Copies the waypoints of a message into `waypoints`.
  void waypoints(std::size_t message, std::vector<Waypoint>& waypoints) const;

  /// The reference of a track; shares ownership of the track.
  static Reference reference(std::shared_ptr<const GoalTrack> track);

 private:
  struct Leg {
    double begin = 0.0, end = 0.0;  // [s]
    Vec3<double> p_0{}, v_0{}, p_1{}, v_1{};
    double heading_0 = 0.0, heading_1 = 0.0;
    Waypoint said{};
  };
  struct Message {
    double t = 0.0;  // [s]
    std::size_t first = 0, legs = 0;
  };
  struct Messages {
    std::vector<Message> list;
    std::atomic<std::size_t> count{0};
  };
  struct Moving {
    Vec3<double> p{}, v{};
    double heading = 0.0;
    bool heads = false;  // else the heading is free
  };
  /// State of a robot's model.
  struct State {
    std::array<double, Reference::max_states> x;
    std::size_t n;
    operator std::span<const double>() const { return {x.data(), n}; }
  };

  const Message* at(double t) const noexcept;
  const Leg& leg(const Message& message, double t) const noexcept;
  static Moving along(const Leg& leg, double t) noexcept;
  Moving moving(double t) const noexcept;
  Sight<double> own(double t) const noexcept;
  State state(double t) const;

  Model model_;
  Reference own_;
  double speed_;
  std::vector<double> rest_;  // inputs
  std::vector<Leg> legs_;
  Messages messages_;
};

/// A robot and its track.
struct RobotGoals {
  BodyId robot{};
  std::shared_ptr<GoalTrack> track{};
};

}  // namespace sightline
