/// The control loop, from measurement to command: clock, localizer, guard, compensation, team changes, samples and sink.
#pragma once

#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/base.hpp"
#include "sightline/estimator.hpp"
#include "sightline/events.hpp"
#include "sightline/solver.hpp"
#include "sightline/solvers.hpp"
#include "sightline/supervisor.hpp"
#include "sightline/team.hpp"
#include "sightline/world.hpp"
#include "sightline/worlds.hpp"

namespace sightline {

// Measured states that are always finite and bounded.

/// States of all bodies (nx), each with the time of its measurement. All numbers are at most
/// `largest`, and headings have a length. Only take() changes them; it leaves a body with an
/// invalid measurement unchanged.
class ValidStates {
 public:
  /// A greater value is no physical quantity of a robot in SI units, and its square may overflow.
  static constexpr double largest = 1e9;

  /// @param start  states of all bodies (nx) until the first valid measurement; an invalid one is
  ///               replaced by rest at the origin
  ValidStates(const Team& team, std::span<const double> start);

  /// Takes states x (nx) and times [s] of a measurement. An invalid body keeps the time of its last
  /// valid measurement, minus infinity before the first.
  const ValidStates& take(std::span<const double> x, std::span<const double> stamps) noexcept;

  /// Takes states x (nx) that follow from `of`, such as predicted ones. A body is valid if it is
  /// valid in both.
  const ValidStates& take(std::span<const double> x, const ValidStates& of) noexcept;

  operator std::span<const double>() const noexcept { return x_; }
  std::size_t size() const noexcept { return x_.size(); }
  double operator[](std::size_t i) const noexcept { return x_[i]; }
  std::span<const double> stamps() const noexcept { return stamps_; }
  /// Whether the last take() had a valid state of the body.
  bool is_valid(BodyId body) const noexcept { return valid_[at(body)] != 0; }

 private:
  struct Body {
    Model model;
    std::size_t x, nx;  // offset and length
  };
  bool admits(const Body& body, std::span<const double> x) noexcept;
  void take_body(std::size_t i, std::span<const double> x, double stamp, bool can_be_valid) noexcept;

  std::vector<Body> bodies_;
  std::vector<double> x_, stamps_, scratch_;
  std::vector<char> valid_;  // of each body
};

// Compensation of command delays and constant disturbances that the planning model omits.
//
// It acts between the state estimate and the controllers, for the motion
//
//   x' = f(x, u(t - delay)) + push(x, w)
//
// A command given at t takes effect at t + delay. The controllers therefore plan from the state at
// t + delay, predicted under the commands in flight. The disturbance w, an acceleration in G, is
// the part of the measured motion that the commands do not explain. Between two measurements that
// are s apart
//
//   w <- w + (1 - e^{-s / time}) (v - v') / s,
//
// where v' is the velocity that the model reaches from the previous measurement, under w. States
// that are neither pose nor velocity, such as a lagging tilt, follow from the commands alone. A
// gain error then enters w and leaves no offset. The constant command u_w cancels w:
//
//   B u_w = -w,   B = d v' / d u after the lags have settled,
//
// in the least-squares sense, with inputs as fractions of their range. It is added to the
// controllers' inputs. The controllers plan without w and for the remaining command, from a state
// without the part of the lags that u_w maintains. The effect is that of w in their prediction and
// of u_w in u*. The tilt due to u_w adds to the tilt of the plan.

/// Source of a robot's u*.
enum class FeedForwardFrom {
  none,       ///< u* of the team
  reference,  ///< the input with which the robot's model follows its reference: FeedForward
};
inline constexpr std::array<std::string_view, 2> feed_forwards = {"none", "reference"};

/// Compensation settings of one robot.
struct RobotCompensation {
  BodyId robot;
  double command_delay = 0.0, disturbance_time = 0.0;
  FeedForwardFrom feed_forward = FeedForwardFrom::none;

  static constexpr auto parameters() {
    using C = RobotCompensation;
    return Parameters{parameter("command_delay", &C::command_delay, "s", {0.0, 1.0, "0 to 1"},
                                "from a command to its effect, with an allowance for lags"),
                      parameter("disturbance_time", &C::disturbance_time, "s", {0.05, 60.0, "0.05 to 60"},
                                "time constant of the estimated disturbance; default: no estimate"),
                      parameter("feed_forward", &C::feed_forward, feed_forwards, "source of u*")};
  }
};

/// @throws std::invalid_argument for a body that is no robot of the team, for a robot that is named
///         twice, for numbers out of their range, and for an estimate of a disturbance that the
///         robot's commands cannot cancel
void validate(const Team& team, const std::vector<RobotCompensation>& robots);

class Compensation {
 public:
  static constexpr double longest_delay = 1.0;                     ///< of a command [s]
  static constexpr double least_time = 0.05, longest_time = 60.0;  ///< time constants of the estimate [s]
  /// Greatest fraction of an input's half range that u_w uses.
  static constexpr double most_part = 0.8;

  /// @param period  shortest time between two commands [s]; sizes the input history
  /// @throws std::invalid_argument as validate()
  Compensation(const Team& team, const std::vector<RobotCompensation>& robots, double period);
  ~Compensation();
  Compensation(const Compensation&) = delete;
  Compensation& operator=(const Compensation&) = delete;

  // The loop calls these functions once each period, in this order. None throws, allocates, locks or
  // prints.

  /// Takes a measurement of a robot. Ignores one that is invalid or not newer than the last.
  void look(BodyId robot, const ValidStates& measured) noexcept;
  /// The states (nx) at which the commands of t take effect. For a robot: after its own delay,
  /// without the part that u_w maintains. For other bodies: after the longest delay. Valid until
  /// the next call.
  /// @param estimate  states at t (nx)
  std::span<const double> ahead(double t, const ValidStates& estimate) noexcept;
  /// u_w of all robots (nu), to be added to the controllers' inputs.
  std::span<const double> added() const noexcept { return added_; }
  /// The part of the states of all bodies (nx) that u_w maintains; ahead() subtracts it.
  std::span<const double> held() const noexcept { return held_; }
  /// Tilt of each body (Sight::lean) due to u_w, in addition to that of the controllers' inputs.
  std::span<const Vec2<double>> lean() const noexcept { return lean_; }
  /// Writes a robot's u* (nu) at time t [s] and state x (nx of the robot), if it follows from the
  /// reference; else leaves u_ref unchanged.
  void write_reference_inputs(BodyId robot, const Reference& x_ref, double t, const double* x,
                              std::span<double> u_ref) noexcept;
  /// Records the inputs u of all robots (nu) that are given at t [s].
  void record(double t, std::span<const double> u) noexcept { history_.record(t, u); }
  /// Discards all knowledge of a robot that joins the team.
  void forget(BodyId robot) noexcept;

  /// Longest command delay of all robots [s].
  double lead() const noexcept { return lead_; }
  /// The estimated disturbance of a robot [m/s^2], in G; 0 without an estimate.
  Vec3<double> disturbance(BodyId robot) const noexcept;

 private:
  struct Member;  // a body whose state is compensated, or only predicted

  static void find_counter(Member& member, const Agent& agent);
  void find_steady(const Member& member, std::span<const double> x) noexcept;

  std::vector<Member> members_;
  std::vector<int> member_of_;  // index into members_ for each body; -1: none
  InputHistory history_;
  double lead_;
  std::vector<double> x_, scratch_, added_, held_;
  std::vector<Vec2<double>> lean_;
};

// Estimates the poses of robots without a position sensor, between the measurement and the
// controllers.

/// A robot without a position sensor.
struct LocalizedRobot {
  BodyId robot{};
  SensorMount mount{};             ///< of its camera
  std::vector<BodyId> observes{};  ///< bodies whose sightings localize it
  FilterOptions filter{};
  double camera_rate = 30.0;  ///< [Hz], > 0
};

struct LocalizerOptions {
  std::vector<LocalizedRobot> robots{};
  BroadcastOptions broadcast{};  ///< `sighting_rate` is the highest rate of the cameras that observe the body
  Cycles cycles = Cycles::refused;

  /// @throws std::invalid_argument naming a number out of its range
  void check() const;
};

/// The graph of the localized robots.
/// @throws std::invalid_argument for options out of range, for a robot whose model has no position
///         or no heading, for a graph that LocalizationGraph refuses, and for a filter of attitudes
///         that observes a localized robot
LocalizationGraph localization_graph(const Team& team, const LocalizerOptions& options);

/// The outcome of one detection in the filter.
struct DetectionFit {
  BodyId observer{}, target{};
  double stamp = 0.0;  ///< of the exposure [s]
  Fit fit{};
};

/// The states of robots that are localized by vision, each from its own filter. A filter receives the
/// robot's motion, the detections of its camera, and the broadcasts of the detected bodies. The
/// measured state of such a robot is ignored.
///
/// Each estimate() processes motions, then broadcasts, then detections, robots of lower tiers
/// first. A localized robot passes its estimate to the robots that observe it. The velocities among
/// a robot's states are those of the model under the applied inputs, filtered towards those of the
/// pose filter.
///
/// The stamp of a robot is that of its estimate, the end of its last motion. It is minus infinity
/// before the first estimate, and it ages if no motion arrives. Until then the robot is at its
/// start, with the received velocity. The result depends on the inputs alone, bit for bit. After
/// construction nothing allocates, throws, locks or prints.
class Localizer {
 public:
  /// @param start  states of all bodies (nx)
  /// @throws std::invalid_argument as localization_graph(), and for a start of another length
  Localizer(const Team& team, std::span<const double> start, const LocalizerOptions& options);

  /// Sets the presence of each body, as for a World.
  void set_presence(std::span<const Presence> presence) noexcept;
  /// The measurement at t [s] with the states and stamps of localized robots from their filters. t
  /// must rise. Valid until the next call.
  Measured estimate(double t, const Measured& received) noexcept;
  /// Records that the inputs u (nu) are in force for `periods` periods of `period` [s], from the
  /// last estimate() on.
  void apply(std::span<const double> u, double period, std::int64_t periods) noexcept;

  /// Whether every localized robot has had a pose estimate. Until then the loop requests no plan.
  bool knows_all() const noexcept { return knows_all_; }
  /// Of each body, the standard deviation of its estimated position [m]; 0: measured; infinity:
  /// unknown.
  std::span<const double> sigma() const noexcept { return sigma_; }
  /// Of each body, the uncertainty of its view of the body that it observed last; zero if it is not
  /// localized.
  std::span<const ViewUncertainty> uncertainties() const noexcept { return uncertainties_; }
  /// Of each body; `known` is false for a body that is not localized.
  std::span<const PoseEstimate> estimates() const noexcept { return estimates_; }
  /// The views of the localized robots, for a Search; lower tiers first.
  std::span<const View> views() const noexcept { return views_; }
  /// Starts a robot's filter at a pose that is known otherwise: p [m] in G, psi [rad].
  /// @param P  covariance of (p, psi), positive definite
  void start(BodyId robot, const Vec3<double>& p, double psi, const Mat<4, 4>& P) noexcept;
  /// Outcomes of the detections of the last estimate().
  std::span<const DetectionFit> fits() const noexcept { return fits_; }
  const LocalizationGraph& graph() const noexcept { return graph_; }

 private:
  struct Robot {
    LocalizedRobot what;
    std::size_t body = 0, x = 0, u = 0, nx = 0;
    std::vector<std::size_t> velocities{};      // among its states
    std::vector<Vec3<double>> velocity_axes{};  // of each in G, at heading 0
    std::vector<std::size_t> tilt{};            // among its states; only the model has them
    std::optional<std::size_t> rate{};          // of the heading, among its states
    std::unique_ptr<PoseFilter> filter{};
    std::array<MotionSample, PoseFilter::memory> received{};
    std::size_t counted = 0;
    std::vector<double> predicted{};
  };

  Robot made(const LocalizedRobot& what) const;
  void forget(Robot& robot) noexcept;
  void move(const RobotMotion& motion) noexcept;
  void look(Robot& robot, View& view, const Detection& detection) noexcept;
  void accept_measurement(Robot& robot, View& view, double t) noexcept;

  Team team_;
  LocalizerOptions options_;
  LocalizationGraph graph_;
  std::vector<Robot> robots_;           // lower tiers first
  std::vector<int> robot_of_;           // index into robots_ for each body; -1: its pose is measured
  std::vector<BroadcastTrack> tracks_;  // of each body
  std::vector<Presence> presence_;
  std::vector<double> start_, states_, stamps_, sigma_;
  std::vector<ViewUncertainty> uncertainties_;
  std::vector<PoseEstimate> estimates_;
  std::vector<DetectionFit> fits_;
  std::vector<View> views_;  // of the robots, in the order of robots_
  bool knows_all_ = false;
};

// The record of one control period that the loop passes to the log.

/// Kinds of reported events.
enum class EventKind : std::uint8_t {
  missed_period,    ///< a steady clock's period was over before the update; value: periods missed
  solver_status,    ///< the status of a controller changed; value: the new Status as a number
  input_refused,    ///< a command was not finite or above its limit after the solver's clamp and was not
                    ///< applied
  samples_dropped,  ///< the log could not keep up; value: samples dropped so far
  // The fallback level of a robot changed, in the order of FallbackLevel; value: the body.
  valid,
  predicted,
  slowed,
  hold,
  land,
  grounded,
  // Measurements of a body are refused from now on, in the order of MeasurementFault; value: the
  // body.
  measurement_not_finite,
  measurement_heading,
  measurement_world,
  measurement_speed,
  measurement_jump,
  measurement_frozen,
  measurement_time,
  barrier_conflict,  ///< no command keeps all hard distances; value: the body
  // An event of the script; value: its index.
  event_occurred,    ///< its trigger fired
  event_in_force,    ///< its changes to the team are in force, or its stage has begun
  event_ignored,     ///< rejected, the team is unchanged; reported once
  team_late,         ///< the next team was not ready in time; value: periods
  pairs_left_out,    ///< more pairs of a swarm are near than there is room for; value: how many more
  added_too_near,    ///< a body joined closer to another than its minimum distance; value: the body
  search,            ///< a robot localized by vision searches for its target; value: the body
  found,             ///< the target is in view again; value: the body
  stale,             ///< a part of the team receives no predictions of this body any more; value: the body
  received,          ///< all parts receive them again; value: the body
  robot_ready,       ///< a robot that an event adds has taken off and holds; value: the body
  robot_refused,     ///< a robot that an event adds cannot join, the event is ignored; value: the body
  view_certified,    ///< from now on its view of the target is certified; value: the body
  view_uncertified,  ///< it is not certified any more; value: the body
  view_handed_over,  ///< its view ends, that of another robot is certified; value: the body
  count_             ///< no event: how many kinds there are
};
inline constexpr int event_kinds = static_cast<int>(EventKind::count_);
std::string_view to_string(EventKind kind);

struct Event {
  double time = 0.0;  ///< [s]
  EventKind kind{};
  int controller = 0;
  double value = 0.0;
};

/// Record of one update of one controller.
struct SolverRecord {
  Status status{};
  double residual = std::numeric_limits<double>::infinity();  ///< infinity: unknown
  int iterations = 0;
  double solve_us = 0.0;         ///< measured; written to timing.csv only
  std::int64_t allocations = 0;  ///< on the control thread, state in to command out
  int pairs = 0;                 ///< pairs of swarms in the constraints
  bool answered =
      true;  ///< false: the solver was not run: a late update is in progress, or a body was never measured
};

/// Effect of the barrier on one robot's command in one update.
struct BarrierRecord {
  bool active = false;                                       ///< it changed the command, or would have
  bool conflict = false;                                     ///< no command keeps all hard distances
  double reserve = std::numeric_limits<double>::infinity();  ///< smallest of all neighbours [m]
};

/// The certified view of one robot in one update.
struct ViewRecord {
  bool certified = false;  ///< the target stays in view, whatever it does within its bounds
  bool active = false;     ///< the filter of the view changed the command
  bool requests = false;   ///< the target is requested to slow down
  double reserve = std::numeric_limits<double>::infinity();  ///< of the set, least; < 0 outside [m]
  ViewReserve least = ViewReserve::near;                     ///< which one, or the condition that is missed
  BodyId target{};                                           ///< of the view in force; none: index < 0
};

/// Record of one control period. All vectors are sized before the loop starts and never grow.
struct Sample {
  /// Content of the sample. `states`: no update; only time, x, truth_known, u in force, presence,
  /// levels and events. Written for a missed period, or after the last command.
  enum class Of : std::uint8_t { update, states };
  Of of = Of::update;
  double time = 0.0;      ///< of the measurement [s]
  std::vector<double> x;  ///< true states of all bodies (nx); measured ones if the truth is unknown
  bool truth_known = true;
  std::vector<Quaternion> attitudes{};  ///< of all bodies, true as x; no_attitude: it follows from x and u
  std::vector<double> measured;         ///< as measured, before the localizer (nx)
  std::vector<double> stamps{};         ///< time of each body's measurement [s]
  std::vector<Detection> detections{};  ///< the first detection_count are valid
  std::size_t detection_count = 0;
  std::vector<RobotMotion> motions{};  ///< the first motion_count are valid
  std::size_t motion_count = 0;
  std::vector<BodyBroadcast> broadcasts{};  ///< the first broadcast_count are valid
  std::size_t broadcast_count = 0;
  std::vector<PoseEstimate> estimates{};  ///< of each body, `known` if localized; empty: no localizer
  std::vector<DetectionFit> fits{};       ///< of detections, the first fit_count are valid
  std::size_t fit_count = 0;
  std::vector<double> u;                  ///< applied inputs (nu)
  std::vector<double> raw_u;              ///< the solvers' inputs before their clamp (nu)
  std::vector<SolverRecord> solvers;      ///< one for each controller
  std::vector<BarrierRecord> barriers{};  ///< one for each robot
  std::vector<ViewRecord> views{};        ///< one for each robot
  std::vector<Presence> presence{};       ///< of each body
  std::vector<FallbackLevel> levels{};    ///< of each body; all valid without a supervisor
  bool team_answered = false;             ///< a requested team took over, or was refused
  bool has_path = false;
  std::vector<double> path;      ///< predicted states (N+1 x nx), valid if has_path
  double path_step = 0.0;        ///< time between two predicted states [s]
  double path_time = 0.0;        ///< time of the first predicted state [s]
  std::vector<double> path_u{};  ///< planned inputs, as `path` (N+1 x nu); empty: not recorded
  double update_us = 0.0;        ///< measured: state in to command out, all controllers
  int event_count = 0;
  std::vector<Event> events = std::vector<Event>(8);  ///< room for all of a period that change the team
};

/// The tilt of a body's true attitude at the sample; `of_model` if the attitude is unknown.
Vec2<double> true_lean(const Vec2<double>& of_model, BodyId body, const Sample& sample) noexcept;
/// The true Sight of a body at the sample: its model at x and u, with its true tilt.
Sight<double> true_sight(const Team& team, BodyId body, const Sample& sample) noexcept;

// Safety checks around the controllers: supervisor, search, certified views and barrier of one team,
// with one state estimate.
//
//   measurement -> supervisor -> state estimate -> solver -> supervisor -> search -> certified view
//   -> barrier -> input
//
// A robot that lands is not kept above the floor, and a grounded robot stays where it is. If a
// body was not measured for longer than hold_after, the barrier uses its position bound at
// hold_after. Growing the bound further would make every command infeasible, and no robot could
// land. For the same reason the barrier limits the standard deviation of an estimated position to
// sigma_most.

enum class BarrierMode {
  off,
  on,
  report,  ///< computes and reports, applies nothing
};
inline constexpr std::array<std::string_view, 3> barrier_modes = {"off", "on", "report"};

/// Distance that robots keep to a body, and the assumptions about it.
struct BodySafety {
  double d_hard = 0.6;     ///< centre to centre [m], > 0
  double speed_max = 1.5;  ///< of a body that is no robot, or is not received [m/s], >= 0
  std::string
      robot{};  ///< model name, if another part steers this body as a robot with its own barrier; else empty
};

/// Limits that a robot receives in flight.
struct LimitsToCome {
  BodyId robot;
  InputLimits limits;
};

/// What a robot does where its view is not certified.
enum class OutsideView {
  solver,  ///< the controllers' command, until the state is in the set
  back,    ///< the command that comes nearest to the set
};
inline constexpr std::array<std::string_view, 2> outside_views = {"solver", "return"};

/// A view that is to be certified, while the observer observes the target. A certified view ends only
/// once that of another observer of the target is certified, if there is one.
struct CertifiedView {
  BodyId observer{}, target{};
  ViewBounds bounds{};
  OutsideView outside = OutsideView::solver;
  double unrequested = 0.0;    ///< greatest speed of a target that slows down on request [m/s]; 0: none does
  double request_delay = 0.0;  ///< from a request to the target's command [s]
  double request_gain = 0.0;   ///< by which such a target gains on one of bounds.speed, at most [m]
  double slowing = 0.0;        ///< its deceleration on request [m/s^2]
  bool is_on_request() const { return unrequested > 0; }
  /// Keeps the set of the certificate; constant, shared by all flights.
  std::shared_ptr<const ViewFilter> filter{};
  double speed_most = 0.0;        ///< largest speed of a target that can be certified [m/s]
  std::string_view limited_by{};  ///< the condition that limits it

  static constexpr auto parameters() {
    return Parameters{
        KeyText{"observer", "a robot", "whose sensor sees the target", "must be given"},
        KeyText{"target", "a body", "which the observer observes, or does after an event", "must be given"},
        parameter("speed_unrequested", &CertifiedView::unrequested, "m/s", from_zero,
                  "greatest speed of a robot that slows down to speed_max on request; 0: the target is none"),
        parameter("request_delay", &CertifiedView::request_delay, "s", Bounds{0.0, 2.0, "0 to 2"},
                  "from a request to the target's command"),
        KeyText{"velocity_error", "> 0",
                "of an observer localized by vision: greatest error of its own velocity [m/s]", "none"},
        KeyText{"turn_error", "> 0",
                "of an observer localized by vision: greatest error of its own mean yaw rate [rad/s]",
                "none"},
        parameter("outside", &CertifiedView::outside, outside_views,
                  "outside the set: the solver's command, or the one nearest to the set")};
  }
};

struct GuardOptions {
  std::optional<SupervisorOptions> supervisor{};
  BarrierMode barrier = BarrierMode::off;
  BarrierOptions barrier_options{};
  double position_sigma = 0.0;           ///< of a measured position, each axis [m], >= 0
  std::vector<BodySafety> bodies{};      ///< in the order of the team; missing ones have the defaults
  double period = 0.01;                  ///< of the commands [s]
  SearchOptions search{};                ///< for robots that are localized by vision
  std::vector<BodyId> searchers{};       ///< robots that search
  std::vector<double> command_delays{};  ///< of each body, from a command to its effect [s]; empty: none
  std::vector<LimitsToCome> limits_to_come{};  ///< the barrier uses the tightest of all limits
  std::vector<CertifiedView> views{};          ///< with their filters
  /// Whether absent robots stay in the world. The barrier then keeps the distance from them and
  /// from robots that land, as from bodies that do not give way.
  bool absent_robots_stay = false;
  /// Threads for the barriers of `shared_from` robots or more; null: the calling thread alone. The
  /// result is the same.
  std::shared_ptr<ThreadPool> pool{};
  static constexpr int shared_from = 32;
};

/// Checks what the constructor of a Guard checks.
/// @throws std::invalid_argument as it does
void validate(const Team& team, const GuardOptions& options);

class TeamBarrier;
class TeamView;

class Guard {
 public:
  /// Greatest standard deviation of an estimated position that the barrier uses [m].
  static constexpr double sigma_most = 0.5;

  /// @throws std::invalid_argument for options out of their range, and for a robot whose model the
  ///         barrier does not support
  Guard(const Team& team, const GuardOptions& options);
  ~Guard();
  Guard(const Guard&) = delete;  // its barriers refer to its team
  Guard& operator=(const Guard&) = delete;

  /// Updates the state estimate of all bodies at t [s].
  /// @param measured  states of all bodies (nx), unfiltered
  /// @param stamps  time of the measurement of each body [s]
  /// @param sigma  of each body, standard deviation of an estimated position [m]; 0: it is
  ///               measured; infinity: unknown. Empty: all are measured
  /// @param poses  of each body, its estimate if it is localized by vision; they must outlive
  ///               keep_distances(), which uses them for certified views. Empty: none is
  const ValidStates& accept_measurement(double t, std::span<const double> measured,
                                        std::span<const double> stamps, std::span<const double> sigma = {},
                                        std::span<const PoseEstimate> poses = {}) noexcept;
  /// Whether a measurement of each body was accepted once; without a supervisor, whether each
  /// present robot had a position. Until then the loop requests no plan.
  bool knows_all() const noexcept { return supervisor_ ? supervisor_->knows_all() : !awaits_position_; }
  /// Takes the views of the searchers at t [s], in any order, after accept_measurement().
  void look(double t, std::span<const View> views) noexcept;
  // fall_back() and then keep_distances(), after accept_measurement(), turn the controllers' inputs
  // u (nu) into the command from t on. x are the states at which the command takes effect: the
  // estimate, or predicted over the commands in flight.

  /// Replaces the input of a robot on a fallback level by the supervisor's, and that of a searcher
  /// without its view by the search's.
  /// @param plan_ages  of each body [s]; values of bodies that are no robots are ignored
  /// @param added  offset to the inputs (nu), such as wind compensation; the limits hold for the
  ///               sum
  void fall_back(double t, const ValidStates& x, std::span<const double> plan_ages,
                 std::span<const double> added, std::span<double> u) noexcept;
  /// Changes u to inputs that keep the certified views, and then to the nearest that keep the hard
  /// distances; `added` as above.
  void keep_distances(double t, const ValidStates& x, std::span<const double> added,
                      std::span<double> u) noexcept;
  /// Records that the inputs u (nu) are applied from t [s] on.
  void record(double t, std::span<const double> u) noexcept;
  /// Whether the last measurement of a body was accepted.
  bool trusts(BodyId body) const noexcept { return !supervisor_ || supervisor_->trusts(body); }

  /// Switches to another membership. The barrier ignores bodies that are absent, except for robots
  /// that stay. Robots that sink may pass the floor. See Supervisor::follow().
  void follow(const Membership& now, double t, std::span<const double> x) noexcept;
  /// Sets which robots receive each other's messages. Robots that do not are uncooperative to each
  /// other. Null: all do. The object must outlive the guard.
  void set_connectivity(const Connectivity* connectivity) noexcept { connectivity_ = connectivity; }
  /// Age of the state estimate of each body at the last accept_measurement() [s].
  std::span<const double> ages() const noexcept { return ages_; }

  /// Events of this period.
  std::span<const Event> events() const noexcept { return events_; }
  /// One record for each robot; empty without a barrier.
  std::span<const BarrierRecord> barriers() const noexcept;
  /// One record for each robot; empty without a certified view.
  std::span<const ViewRecord> views() const noexcept;
  /// One level for each body; `valid` for all without a supervisor, and for bodies that are no
  /// robots.
  std::span<const FallbackLevel> levels() const noexcept { return levels_; }
  const Search& search() const noexcept { return search_; }
  /// Empty without a supervisor.
  const std::optional<Supervisor>& supervisor() const noexcept { return supervisor_; }

 private:
  bool is_there(BodyId body) const noexcept { return presence_[at(body)] != Presence::absent; }
  void see_absent(double t, std::span<const double> measured, std::span<const double> stamps) noexcept;
  void emit(const Event& event) noexcept;
  void emit_stale(double t) noexcept;

  Team team_;
  GuardOptions options_;
  const Connectivity* connectivity_ = nullptr;
  std::vector<char> stale_;  // of each body, as last reported
  std::optional<Supervisor> supervisor_;
  Search search_;
  std::vector<char> searches_;  // whether each searcher searches, as last reported
  ValidStates estimated_;
  ValidStates seen_;  // as measured; of absent robots that stay
  std::vector<double> ages_, stamps_;
  std::vector<double> sigmas_;    // of each body, last received [m]
  bool awaits_position_ = false;  // a robot that is present has never had a position
  std::vector<Presence> presence_;
  std::vector<FallbackLevel> levels_;
  std::unique_ptr<TeamBarrier> barrier_;  // null: none
  std::unique_ptr<TeamView> view_;        // null: none
  std::vector<Event> events_;
};

// The control loop: once per period it measures, localizes, estimates, solves, checks, guards, passes
// the gate and applies.

class Clock;
class Compensation;
class Guard;
class Localizer;
struct Sample;
template <class T>
class Sink;
class Solver;
class Team;
class TeamSwitcher;
class World;

/// The solvers of one loop, each with its own Ocp.
using Controllers = std::vector<std::reference_wrapper<Solver>>;

/// A message that a simulation sends to the events of a script.
struct TimedSignal {
  double at = 0.0;  ///< [s], >= 0
  std::string name;
};

struct LoopOptions {
  double duration = 60.0;      ///< [s]; round(duration / period) periods
  double period = 0.01;        ///< [s], that of each controller's horizon
  double path_interval = 0.1;  ///< between two samples with a predicted path [s]; 0: no paths
  /// Longest time before a period in which solvers warm up, if the clock waits [s]; 0: they do not.
  double warm_up = 0.0;
  /// Number of allocations of the calling thread so far; null: not counted.
  std::int64_t (*allocations)() noexcept = nullptr;
  /// If true, the loop ends at the next period.
  const std::atomic<bool>* stop = nullptr;
  /// Longest wait for room in the sink, if the clock waits for the log [s]. After that, samples are
  /// dropped.
  double log_patience = 30.0;
  /// Supervisor, search and barrier. Must be built for the world's team; not shared between loops.
  /// If null, the last valid measurements are the state estimate, and the gate alone checks
  /// commands.
  Guard* guard = nullptr;
  /// Estimates the poses of robots without a position sensor. Must be built for the world's team;
  /// not shared between loops. If null, states are as measured.
  Localizer* localizer = nullptr;
  /// Compensates command delays and disturbances. Must be built for the world's team; not shared
  /// between loops. If null, commands are assumed to act at once.
  Compensation* compensation = nullptr;
  std::vector<LatePlan> late_plans{};  ///< injected faults
  /// Changes the team in flight; its present solver is then the only controller. If null, the team
  /// stays.
  TeamSwitcher* team_switcher = nullptr;
  std::vector<TimedSignal> signals{};  ///< sent to the team switcher
  /// Minimum distance to each body [m]; an event reports a body that joins closer.
  std::vector<double> d_hard{};
  static constexpr double at_one_place = 0.01;  ///< value of missing entries of d_hard [m]
};

/// The result of a run.
struct LoopOutcome {
  std::int64_t updates = 0;  ///< periods in which the controllers were run
  std::int64_t missed = 0;   ///< periods that ended before they could begin
  std::int64_t dropped = 0;  ///< samples that found no room in the sink
  std::int64_t refused = 0;  ///< commands of a robot that were replaced, after a controller or at the gate
  std::int64_t max_allocations = 0;  ///< in one update: state in to command out, with its triggers
  bool finite = true;    ///< false: the world could not go on; for a simulated world, a state was not finite
  bool stopped = false;  ///< ended by the stop flag
};

/// A sample whose vectors are sized for a loop: the prototype of its sink's items.
/// @param team_switcher  switcher of the loop, or null
Sample sized_sample(const World& world, const Controllers& controllers,
                    const TeamSwitcher* team_switcher = nullptr);
/// The same for a world of that team that measures states alone.
Sample sized_sample(const Team& team, const Controllers& controllers,
                    const TeamSwitcher* team_switcher = nullptr);

/// Runs controllers in a world.
///
/// Period k, at t = k period: the loop measures the world and runs each controller in turn. If a
/// robot's command is not finite or not within its limits, the last good one is applied and an
/// event reports it. The sample goes into the sink, and the command to the world. If a steady clock
/// missed periods, the previous command stayed in force. If an update misses its deadline, the
/// previous plan stays in force.
///
/// The localizer runs after the measurement; the sample has the measurement unchanged. The guard
/// runs after the measurement and before the command. After the guard all states are ValidStates,
/// and the world takes a Command, which only the gate makes. Whatever is measured or planned, the
/// applied input is finite and within the limits in force. The loop does not allocate, lock, throw
/// or print.
class Loop {
 public:
  /// All arguments must outlive the loop.
  /// @throws std::invalid_argument unless each robot of the world is steered by exactly one
  ///         controller, each body of a controller is in the world with the same model, and the
  ///         sink's items are of sized_sample()
  Loop(World& world, const Controllers& controllers, Clock& clock, Sink<Sample>& sink,
       const LoopOptions& options);
  ~Loop();

  /// Runs all periods, once; closes the sink at the end.
  LoopOutcome run() noexcept;

 private:
  struct Stages;
  std::unique_ptr<Stages> stages_;
};

// The clocks of the control loop: simulated time and the machine's monotonic clock.

/// When a requested team takes over.
enum class TeamDue {
  now,       ///< the loop waits for the team
  if_ready,  ///< in this period if the team is ready, else in a later one
  not_yet,
};

/// Divides time into periods, counted from 0. For one thread.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Starts period 0 now or at the next multiple of the period.
  /// @param period  [s], > 0
  virtual void start(double period) noexcept = 0;
  /// Waits until period k begins.
  /// @return the current period: k, or a later one if k is already over
  virtual std::int64_t wait(std::int64_t k) noexcept = 0;
  /// Waits until `ahead` [s] before period k begins. @return whether that time lies ahead; no, if
  /// it has passed, or if periods begin at once
  virtual bool wait_before(std::int64_t /*k*/, double /*ahead*/) noexcept { return false; }
  /// Whether time stands still while the log catches up.
  virtual bool waits_for_log() const noexcept = 0;
  /// When a team that was requested before period k takes over.
  virtual TeamDue team_due(std::int64_t) const noexcept {
    return waits_for_log() ? TeamDue::now : TeamDue::if_ready;
  }
};

/// Simulated time, as fast as the machine computes. No period is ever missed.
class SimulatedClock final : public Clock {
 public:
  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override { return k; }
  bool waits_for_log() const noexcept override { return true; }
};

/// The machine's monotonic clock. Periods begin at multiples of the period, so all programs of one
/// machine share a grid. A late period is followed by the next one of the grid, so delays do not
/// accumulate. A period that ended before it could begin is missed; the period that runs instead
/// begins at once.
class SteadyClock final : public Clock {
 public:
  void start(double period) noexcept override;
  std::int64_t wait(std::int64_t k) noexcept override;
  bool wait_before(std::int64_t k, double ahead) noexcept override;
  bool waits_for_log() const noexcept override { return false; }

 private:
  std::int64_t start_ns_ = 0, period_ns_ = 1;
};

// A sink for a producer's items, and a lock-free ring buffer for one producer and one consumer.

/// Takes a producer's items one at a time, in the producer's thread; allocates nothing.
template <class T>
class Sink {
 public:
  virtual ~Sink() = default;

  /// The next item to write, or nullptr if there is no room.
  virtual T* claim() noexcept = 0;
  /// Whether the sink takes items between the regular ones.
  virtual bool takes_between() const noexcept { return false; }
  /// As claim(), for an item between the regular ones.
  virtual T* claim_between() noexcept { return nullptr; }
  /// Takes over the claimed item.
  virtual void publish() noexcept = 0;
  /// Receives an item that found no room. A sink that acts on items or displays them acts on this
  /// item, too. It does not keep the item.
  virtual void drop(const T&) noexcept {}
  /// Ends the stream: no item follows.
  virtual void close() noexcept = 0;
  /// Whether the consumer has stopped: claim() then never has room again.
  virtual bool is_abandoned() const noexcept { return false; }
};

/// Items are made once, as copies of a prototype, and are written and read in place. There are no
/// locks. The producer never waits and does not wake the consumer, which polls.
template <class T>
class SpscQueue final : public Sink<T> {
 public:
  /// @param capacity  items that can wait, >= 1
  /// @param between  claim_between() requires fewer waiting items than this; 0: it never has room
  SpscQueue(std::size_t capacity, const T& prototype, std::size_t between = 0)
      : items_(capacity, prototype), between_(between) {
    assert(capacity > 0 && "a queue holds something");
  }

  /// Producer: the next item to write, or nullptr if the queue is full.
  T* claim() noexcept override {
    const std::size_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) == items_.size()) return nullptr;
    return &items_[written % items_.size()];
  }
  bool takes_between() const noexcept override { return between_ > 0; }
  T* claim_between() noexcept override {
    const std::size_t waiting =
        written_.load(std::memory_order_relaxed) - read_.load(std::memory_order_acquire);
    return waiting < between_ ? claim() : nullptr;
  }
  /// Producer: publishes the claimed item.
  void publish() noexcept override {
    written_.store(written_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }
  /// Producer: ends the stream.
  void close() noexcept override { closed_.store(true, std::memory_order_release); }
  bool is_abandoned() const noexcept override { return abandoned_.load(std::memory_order_acquire); }

  /// Consumer: the oldest item, or nullptr if the queue is empty.
  const T* front() const noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (written_.load(std::memory_order_acquire) == read) return nullptr;
    return &items_[read % items_.size()];
  }
  /// Consumer: releases the item at the front.
  void pop() noexcept { read_.store(read_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  /// Consumer, or its owner if it never started: stops taking items.
  void abandon() noexcept { abandoned_.store(true, std::memory_order_release); }
  /// Consumer: waits for the oldest item; nullptr if the queue is closed and empty.
  const T* wait() const noexcept {
    // Each sleep costs about 10 us, so the sleeps grow with the wait, from 0.2 ms.
    constexpr long longest = 3'200'000;  // [ns]
    for (timespec nap = {0, 200'000};; nap.tv_nsec = std::min(longest, 2 * nap.tv_nsec)) {
      const bool last = closed_.load(std::memory_order_acquire);  // must precede front()
      if (const T* item = front()) return item;
      if (last) return nullptr;
      ::nanosleep(&nap, nullptr);
    }
  }

  std::size_t capacity() const noexcept { return items_.size(); }

 private:
  std::vector<T> items_;
  std::size_t between_;
  // Total counts of items, each on its own cache line.
  alignas(64) std::atomic<std::size_t> written_{0};
  alignas(64) std::atomic<std::size_t> read_{0};
  std::atomic<bool> closed_{false}, abandoned_{false};
};

// Changes of the team in flight: a thread of its own prepares the next solver.
//
// The next solver takes over one period after the event that requests it.
//
//   period k      the loop's update; then look(): an event fires, the thread gets a request
//   meanwhile     the thread changes the membership, makes the Team, its Ocp and solver, transfers
//                 the plan of the robots in both teams, and takes up to 30 steps on the state
//                 predicted for period k + 1.  If any of it fails, nothing has changed; of several
//                 events each is then tried alone
//   period k + 1  swap(): exchanges pointers; the thread receives the previous solver and frees it
//
// In simulated time the loop waits for the thread, so that a run does not depend on thread timing.
// With a steady clock the present team continues until the next is ready, and an event reports the
// delay. The control path does not allocate, lock or throw.

struct Phase;  // the solver, the robots without a solver, and the membership of one team

class TeamSwitcher {
 public:
  /// @param make  makes solvers for teams of this horizon; called on the thread
  /// @param tuned  events that arrive in flight, one a period; null: none
  /// @throws std::invalid_argument for the first fault that faults_of() finds in the script, and if
  ///         the solver is no TeamPlanner; std::system_error if the machine provides no thread
  TeamSwitcher(ActiveTeam start, const Script& script, MakeSolver make,
               std::shared_ptr<TunedScript> tuned = {});
  ~TeamSwitcher();
  TeamSwitcher(const TeamSwitcher&) = delete;
  TeamSwitcher& operator=(const TeamSwitcher&) = delete;

  /// Whether a requested team has neither taken over nor been refused.
  bool pending() const noexcept { return pending_; }
  /// The present phase. The loop takes the first one from here.
  Phase& present() noexcept { return *present_; }
  const Phase& present() const noexcept { return *present_; }
  /// All bodies that are ever present.
  const Team& world() const noexcept { return world_; }

  /// Sets the states in which absent bodies join (nx of the world). Not while a team is pending.
  void set_start(std::span<const double> x) { start_.assign(x.begin(), x.end()); }
  /// Sets, before the first period, the world in which robots that events add take off first.
  void set_world(World& flown_in) { flown_in_ = &flown_in; }
  /// Greatest number of events() that can wait.
  std::size_t events_max() const noexcept { return reported_.capacity(); }

  /// Any thread: passes on an event's signal. @return whether the script has a signal of that name
  bool signal(std::string_view name) noexcept { return monitor_.signal(name); }

  // Called on the control thread, each period.

  /// Whether no change is being prepared.
  bool is_ready() const noexcept { return hand_.load(std::memory_order_acquire) == Hand::control; }
  /// Applies the pending change if it is ready; waits for it if `wait`.
  /// @param x  present states of the world, which bring the new solver's memory into the cache
  /// @return whether the team has changed
  bool swap(double t, const ValidStates& x, std::span<const double> u, bool wait) noexcept;
  /// Evaluates triggers after the update at t, and requests the changes. The next solver continues
  /// from this update's plan. An event that adds a robot waits until World::prepare() lets it join.
  /// Later events, tuned ones too, that change something of one of its robots or terms wait for it.
  /// @param ages  age of the knowledge of each body [s]; empty: all is new
  void look(double t, const ValidStates& x, std::span<const double> u, std::span<const double> ages) noexcept;
  /// Events that occurred or took effect since clear_events().
  std::span<const Event> events() const noexcept { return reported_; }
  void clear_events() noexcept { reported_.clear(); }

 private:
  enum class Hand { control, thread };  // owner of the request and the next phase

  struct Request {
    double t = 0.0;
    std::vector<double> x, u;  // of the world
    std::vector<double> plan;  // [stage][input of the present team]
    std::vector<std::size_t> events;
    bool settles = false;  // ramped weights have reached their final values
  };

  void work() noexcept;
  void prepare() noexcept;
  void make_next(std::span<const std::size_t> events);
  void give_plan(TeamPlanner& planner) const;
  void predict(Phase& next) const;
  void emit(double t, EventKind kind, std::size_t event) noexcept;
  /// The number of a tuned event, behind those of the script.
  std::size_t number_of_tuned(std::size_t i) const noexcept { return script_.events.size() + i; }
  bool takes_tuned(double t) noexcept;
  void report_of(double t, std::size_t event) noexcept;
  void ignore(double t, std::size_t event) noexcept;
  /// Calls `act` with each robot that an event adds and that is absent or lands.
  template <class Act>
  void each_added(const TeamEvent& event, const Act& act) const noexcept;
  Joining joining(double t, const TeamEvent& event) noexcept;
  bool waits_for_another(const TeamEvent& event, std::size_t waiting) const noexcept;
  void request_awaited(double t) noexcept;

  Team world_;
  World* flown_in_ = nullptr;  // null: robots join at once
  std::vector<double> start_;
  Script script_;
  EventMonitor monitor_;
  MakeSolver make_;
  std::shared_ptr<TunedScript> tuned_;
  std::size_t taken_ = 0;             // number of tuned events taken
  std::vector<std::size_t> awaited_;  // events that occurred and are not requested yet
  double period_ = 0.0;
  std::unique_ptr<Phase> present_;
  bool pending_ = false;
  double settles_at_;          // when weights that change now reach their final value [s]
  std::vector<char> ignored_;  // [event]: already reported
  std::vector<Event> reported_;

  // Passed between the two threads; hand_ names the owner.
  std::atomic<Hand> hand_{Hand::control};
  std::atomic<bool> stop_{false};
  ActiveTeam active_team_;
  Request request_;
  std::vector<std::size_t> refused_;  // events
  std::unique_ptr<Phase> next_;       // without a solver: the team stays
  double next_settles_at_;
  ServiceThread thread_{"the change of teams"};
};

}  // namespace sightline
