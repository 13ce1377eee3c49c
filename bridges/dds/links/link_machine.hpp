/// State machine of a robot on a link, from the ground into flight and back, as a table. Uses no
/// messages, no clock and no shared memory.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace sightline::dds {

enum class LinkState : std::uint8_t {
  waiting,     ///< waits for its topics and for its own checks
  ready,       ///< can be armed; the autopilot receives our messages
  arming,      ///< arm request sent
  taking_off,  ///< take-off request sent, then the set-point request
  flying,      ///< flies the task
  holding,     ///< flies with zero velocity; before its task climbs to the height where that begins
  landing,     ///< land request sent
  done,        ///< nothing is sent any more
  pilot,       ///< another operator or a failsafe controls it; nothing is sent any more
};
inline constexpr int link_states = 9;
std::string_view to_string(LinkState state);

/// Reason of the last transition.
enum class LinkReason : std::uint8_t {
  as_requested,
  not_ready,       ///< absent or not ready in time
  arming_refused,  ///< by its answer
  no_answer,       ///< to the arm request
  refused,         ///< take-off or set-points, by its answer
  too_long,        ///< take-off took too long
  disarmed,
  silent,  ///< its messages stopped
  pilot,
  failsafe,  ///< of its autopilot
  no_task,   ///< the task did not start in time
  no_end,    ///< the task exceeded its maximum time
  did_not_land,
  handed_over,  ///< to its autopilot, on the operator's request
  contested,    ///< another program writes set-points to it
  restarted,    ///< a new writer replaced the robot's since arming
  battery_low,
  estimator_invalid,
  moved,      ///< its estimator jumped further than is compensated
  emergency,  ///< the operator stopped its motors
  stamps_stuck,
  misplaced,  ///< not where it is to join the team
  late,       ///< its poses arrive late by its radio
  strayed,    ///< it left the place of its take-off before the task
};
inline constexpr int link_reasons = 24;
/// Part of a sentence: "it was disarmed".
std::string_view to_string(LinkReason reason);

/// Current mode of the autopilot.
enum class AutopilotMode : std::uint8_t {
  other,     ///< any other mode, as before take-off
  takeoff,   ///< takes off, or waits in the air after it
  offboard,  ///< follows our set-points
  land,
};

/// State of a robot at one time, as reported and measured.
struct LinkFacts {
  bool there = false;     ///< its messages are recent
  bool checked = false;   ///< its messages allow arming
  bool unplaced = false;  ///< its checks fail for want of a global origin, which it takes on request
  bool armed = false;
  bool airborne = false;  ///< at the height where its take-off ends
  bool risen = true;      ///< at the height where its task begins
  bool landed = true;
  bool answered = true;  ///< it acknowledged or rejected the last request, or no request is lost
  bool refused = false;  ///< it rejected the last request
  bool failsafe = false;
  bool contested = false;  ///< another program writes set-points to it
  bool restarted = false;  ///< a new writer replaced the robot's since the arm request
  /// Reported reason to end the flight, or not to begin it; as_requested: none.
  LinkReason unfit = LinkReason::as_requested;
  AutopilotMode mode = AutopilotMode::other;
};

/// Order to a robot. The orders follow this sequence; the last three may come at any time.
enum class LinkOrder : std::uint8_t {
  check,      ///< prepare only
  take_off,   ///< arm and take off
  hold,       ///< follow set-points, hold; also after the task
  task,       ///< fly the task
  land,       ///< land and stay on the ground
  hand_over,  ///< stop sending
  emergency,  ///< stop the motors of robots in our control, once, then stop sending
};

/// climb: zero velocity, and upwards as far as the height where the task begins.
enum class Setpoint : std::uint8_t { none, zero, climb, task };
enum class Request : std::uint8_t { none, arm, take_off, offboard, hold, origin, land, emergency };

/// Output of one period.
struct LinkOutput {
  bool heartbeat = false;
  Setpoint setpoint = Setpoint::none;
  Request request = Request::none;
};

/// Time limits of the state machine [s].
struct LinkTimes {
  double ready = 10.0;     ///< waiting: maximum time until ready
  double listened = 2.5;   ///< minimum observation before findings count: a drift of clocks needs 2 s
  double received = 1.2;   ///< ready: minimum time; PX4 requires a heartbeat for more than 1 s
  double called = 3600.0;  ///< ready: maximum time until the take-off order
  double arming = 2.0;     ///< from the arm request until armed
  double takeoff = 30.0;   ///< until it can accept set-points
  double offboard = 2.0;   ///< from the request for a mode until it is in that mode
  double holding = 30.0;   ///< maximum
  double task = 3600.0;    ///< maximum
  double landing = 60.0;   ///< maximum
  double gone = 2.5;       ///< landing: from the loss of its messages until it is given up
  double again = 0.5;      ///< between two requests for the same
  int attempts = 4;        ///< maximum number of requests for the same; land: no limit
};

/// State machine of one robot. step() runs each period and takes at most one row of the table.
/// It brings a robot that waits or has landed out of the mode offboard, where it may not arm.
/// It sends each request again until it is acknowledged, at most `attempts` times; land until the
/// autopilot lands, emergency once. It sends set-points only while the autopilot accepts them.
class LinkMachine {
 public:
  explicit LinkMachine(const LinkTimes& times = {}) : times_(times) {}

  /// @param t  [s], increasing; the first call is the beginning
  LinkOutput step(double t, const LinkFacts& facts, LinkOrder order) noexcept;

  LinkState state() const noexcept { return state_; }
  /// The first reason other than as_requested; as_requested: no such transition.
  LinkReason reason() const noexcept { return reason_; }
  double since() const noexcept { return since_; }  ///< time at which this state began [s]
  /// Whether the robot may be in flight under our control.
  bool in_our_hands() const noexcept { return state_ >= LinkState::arming && state_ <= LinkState::landing; }
  /// Maximum time in a state [s]. The states done and pilot are final and not limited.
  double longest(LinkState state) const noexcept;

 private:
  struct Row;
  static const std::array<Row, 38> table;

  bool holds(const Row& row, const LinkFacts& facts, LinkOrder order, double t) const noexcept;
  void request(Request request, double t, const LinkFacts& facts, LinkOutput& output) noexcept;

  LinkTimes times_;
  LinkState state_ = LinkState::waiting;
  LinkReason reason_ = LinkReason::as_requested;
  bool begun_ = false, took_off_ = false, flown_ = false;
  double since_ = 0.0, there_at_ = 0.0, requested_at_ = 0.0, first_requested_at_ = 0.0;
  Request requested_ = Request::none;  // the last, sent attempts_ times
  int attempts_ = 0;
};

}  // namespace sightline::dds
