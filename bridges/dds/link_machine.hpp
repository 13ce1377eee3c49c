/// What a robot on a link is at, from the ground into flight and back, as a table. No messages, no clock, no memory but its own.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace sightline::dds {

enum class LinkState : std::uint8_t {
  waiting,     ///< for its topics, and for its own checks
  ready,       ///< could be armed; the autopilot hears us
  arming,      ///< was asked to arm
  taking_off,  ///< was asked to take off, then to take set-points
  flying,      ///< flies the task
  holding,     ///< flies with zero velocity
  landing,     ///< was asked to land
  done,        ///< nothing is sent any more
  pilot,       ///< somebody else has it; nothing is sent, for good
};
inline constexpr int link_states = 9;
std::string_view to_string(LinkState state);

/// Why it left its last state.
enum class LinkReason : std::uint8_t {
  as_requested,
  not_ready,       ///< it was not there, or not ready, in time
  arming_refused,  ///< its answer
  no_answer,       ///< to the request to arm
  refused,         ///< take-off or set-points, by its answer
  too_long,        ///< the way into flight
  disarmed,
  silent,  ///< its messages ceased
  pilot,
  failsafe,  ///< of its autopilot
  no_task,   ///< nobody flew it
  no_end,    ///< the task was longer than any
  did_not_land,
  handed_over,  ///< to its autopilot, on a person's request
  contested,    ///< another program writes set-points to it
  restarted,    ///< another one speaks in its place since it was armed
  battery_low,
  estimator_invalid,
  moved,      ///< its estimator jumped further than is followed
  emergency,  ///< a person had its motors stopped
};
inline constexpr int link_reasons = 20;
/// A part of a sentence: "it was disarmed".
std::string_view to_string(LinkReason reason);

/// What the autopilot does now.
enum class AutopilotMode : std::uint8_t {
  other,     ///< nothing of ours, as any mode before take-off
  takeoff,   ///< ours: takes off, or waits in the air after it
  offboard,  ///< takes our set-points
  land,
};

/// What is known of a robot at one time.
struct LinkFacts {
  bool there = false;    ///< its messages are young
  bool checked = false;  ///< and say that it may be armed
  bool armed = false;
  bool airborne = false;  ///< as high as its take-off ends
  bool landed = true;
  bool refused = false;  ///< what was asked last, by its answer
  bool failsafe = false;
  bool contested = false;  ///< another program writes set-points to it
  bool restarted = false;  ///< another one speaks in its place since it was asked to arm
  LinkReason unfit =
      LinkReason::as_requested;  ///< why it cannot go on flying, by what it says of itself; as_asked: it can
  AutopilotMode mode = AutopilotMode::other;
};

/// What a robot is to do, in this order but for the last three, which may come at any time.
enum class LinkOrder : std::uint8_t {
  check,      ///< get ready, no more
  take_off,   ///< arm and take off
  hold,       ///< take set-points, hold; also out of the task
  task,       ///< fly the task
  land,       ///< and stay on the ground
  hand_over,  ///< send nothing any more
  emergency,  ///< stop the motors of what is in our hands, once, and send nothing any more
};

enum class Setpoint : std::uint8_t { none, zero, task };
enum class Request : std::uint8_t { none, arm, take_off, offboard, land, emergency };

/// What is to be sent in this period.
struct LinkOutput {
  bool heartbeat = false;
  Setpoint setpoint = Setpoint::none;
  Request request = Request::none;
};

/// Times of the table [s].
struct LinkTimes {
  double ready = 10.0;      ///< waiting, until it is ready
  double listened = 1.5;    ///< to a robot, until what is found of it counts: a battery speaks once a second
  double received = 1.2;    ///< ready, at least: PX4 wants to hear more than 1 s
  double called = 3600.0;   ///< ready, until it is to take off
  double arming = 2.0;      ///< from the request to arm until it is
  double takeoff = 30.0;    ///< until it is where it takes set-points
  double offboard = 2.0;    ///< until it does, from the request on
  double holding = 30.0;    ///< at most
  double task = 3600.0;     ///< at most
  double landing = 60.0;    ///< at most
  double land_again = 0.5;  ///< from one request to land to the next
};

/// One robot. step() is called each period and takes at most one row of the table. It asks once to arm, once to take off, once to take
/// set-points and once for an emergency, in all its life; landing it asks again. Set-points go out only while the autopilot takes them.
class LinkMachine {
 public:
  explicit LinkMachine(const LinkTimes& times = {}) : times_(times) {}

  /// @param t  [s], rises; the first is the beginning
  LinkOutput step(double t, const LinkFacts& facts, LinkOrder order) noexcept;

  LinkState state() const noexcept { return state_; }
  /// The first reason that was none of ours; as_asked: all went as it should.
  LinkReason reason() const noexcept { return reason_; }
  double since() const noexcept { return since_; }  ///< in this state [s]
  /// Whether somebody has to go on caring: it may be in flight, by us.
  bool in_our_hands() const noexcept { return state_ >= LinkState::arming && state_ <= LinkState::landing; }
  /// The longest it stays in a state [s]; that it stays in done and pilot for good is no flight.
  double longest(LinkState state) const noexcept;

 private:
  struct Row;
  static const std::array<Row, 65> table;

  bool holds(const Row& row, const LinkFacts& facts, LinkOrder order, double t) const noexcept;
  bool requested(Request request) const noexcept { return requested_[static_cast<std::size_t>(request)]; }
  void request(Request request, double t, LinkOutput& output) noexcept;

  LinkTimes times_;
  LinkState state_ = LinkState::waiting;
  LinkReason reason_ = LinkReason::as_requested;
  bool begun_ = false, took_off_ = false;
  double since_ = 0.0, requested_at_ = 0.0;
  std::array<bool, 6> requested_{};  // by Request
};

}  // namespace sightline::dds
