/// Fault handling: state estimates of bodies, fallback levels by age of data, and the search for a lost target.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/events.hpp"
#include "sightline/model.hpp"

namespace sightline {

// The inputs of the last seconds, for predictions from old measurements.

/// A ring buffer of inputs, each in force until the next. Its size is fixed.
class InputHistory {
 public:
  /// @param entries  capacity, >= 1
  /// @param initial  input in force before the first record (nu)
  InputHistory(std::size_t entries, std::span<const double> initial)
      : nu_(initial.size()), times_(entries), rows_(entries * initial.size()) {
    assert(entries > 0 && "a history holds something");
    times_[0] = -std::numeric_limits<double>::infinity();
    std::copy(initial.begin(), initial.end(), rows_.begin());
  }

  /// Records that u (nu) is in force from t [s] on; t must rise.
  void record(double t, std::span<const double> u) noexcept {
    newest_ = (newest_ + 1) % times_.size();
    count_ = std::min(count_ + 1, times_.size());
    times_[newest_] = t;
    std::copy(u.begin(), u.end(), rows_.begin() + static_cast<std::ptrdiff_t>(newest_ * nu_));
  }

  /// Calls piece(from, to, u) for each interval of [from, to) [s] with constant input. Before the
  /// oldest stored entry, the oldest entry counts.
  template <class Piece>
  void visit(double from, double to, Piece&& piece) const {
    std::size_t back = 0;
    while (back + 1 < count_ && time(back) > from) ++back;
    for (double t = from; t < to;) {
      const double until = back > 0 ? std::min(time(back - 1), to) : to;
      if (until > t) piece(t, until, row(back));
      t = std::max(t, until);
      if (back > 0) --back;
    }
  }

 private:
  std::size_t at(std::size_t back) const noexcept { return (newest_ + times_.size() - back) % times_.size(); }
  double time(std::size_t back) const noexcept { return times_[at(back)]; }
  std::span<const double> row(std::size_t back) const noexcept {
    return std::span(rows_).subspan(at(back) * nu_, nu_);
  }

  std::size_t nu_, newest_ = 0, count_ = 1;
  std::vector<double> times_, rows_;
};

// The input that gives a robot of any model a wanted velocity, to hold position or to land.
//
// The velocity after a time tau under a held input u is linearised in u at u*,
//
//   q(u) = (v(x + tau f(x, u), u), turn rate),   q(u) ~ q(u*) + J (u - u*),
//
// and u = argmin |q(u) - q_wanted|^2 + 1e-9 |u - u*|^2, clamped to the limits. Least squares
// leaves out what a model cannot do: a ground robot that is to land stands. For the multirotor q
// is affine in u, and v decays approximately as e^{-t/tau}.

/// Allocates only during construction.
class Brake {
 public:
  /// @param u_ref  u*, the input at rest (nu <= 16)
  /// @param tau    [s], > 0
  Brake(const Model& model, std::span<const double> u_ref, double tau);

  /// Writes the input (nu) that leads from the state x (nx) to this velocity [m/s] in G.
  /// @param turn_rate  to the left [rad/s]
  void operator()(std::span<const double> x, const Vec3<double>& velocity, std::span<const double> u_min,
                  std::span<const double> u_max, std::span<double> u, double turn_rate = 0.0) noexcept;

  static constexpr std::size_t inputs_max = 16;

 private:
  static constexpr std::size_t rows = 4;  // v and the turn rate
  std::array<double, rows> outcome(std::span<const double> x, std::span<const double> u) noexcept;

  Model model_;
  std::vector<double> u_ref_, trial_, rate_, soon_;
  double tau_;
};

// Fallback levels of a robot, chosen by the age and the uncertainty of its data. The worst reason
// decides.
//
//   level      greatest age of data    applied command
//   valid      fresh                   the plan
//   predicted  slow_after              the plan, from a state predicted to the present
//   slowed     hold_after              the plan, scaled
//   hold       land_after              zero velocity, by the predicted state
//   land       older                   steady descent without horizontal velocity, to the ground
//   grounded   -                       zero velocity
//
// For an estimated position its standard deviation decides as well. Within sigma_hold it counts as
// a measured one, within sigma_land the robot holds, beyond it lands.
//
// Transitions: between valid, predicted, slowed and hold, in each direction, by the ages. From
// each of the four to land. From land to grounded, when the robot is on the ground. From grounded
// there is none. A robot that has begun to land continues to land, also when its data return.

enum class FallbackLevel : std::uint8_t { valid, predicted, slowed, hold, land, grounded };
inline constexpr int fallback_level_count = 6;
std::string_view to_string(FallbackLevel level);

/// Greatest age of a robot's data at each level [s].
struct LadderTimes {
  double fresh = 0.02, slow_after = 0.2, hold_after = 0.5, land_after = 2.0;  // do not fall

  static constexpr auto parameters() {
    using T = LadderTimes;
    return Parameters{parameter("fresh", &T::fresh, "s", above_zero, "younger data count as present"),
                      parameter("slow_after", &T::slow_after, "s", above_zero, "age for `slowed`"),
                      parameter("hold_after", &T::hold_after, "s", above_zero, "age for `hold`"),
                      parameter("land_after", &T::land_after, "s", above_zero, "age for `land`")};
  }
};

/// Greatest standard deviation of an estimated position [m], the root of the sum over its axes.
struct LadderSigmas {
  double hold = 1.0, land = 2.0;  // land > hold

  static constexpr auto parameters() {
    using S = LadderSigmas;
    return Parameters{
        parameter("sigma_hold", &S::hold, "m", above_zero, "deviation of an estimated position for `hold`"),
        parameter("sigma_land", &S::land, "m", above_zero, "the same for `land`")};
  }
};

/// Ages of the data that a robot uses [s]; infinity: no data so far.
struct Ages {
  double own = 0.0;       ///< the last good measurement of the robot itself
  double partners = 0.0;  ///< the oldest measurement of the bodies whose couplings act on it
  double plan = 0.0;      ///< the last good plan
};

/// The level for data of this age [s].
FallbackLevel level_at(const LadderTimes& times, double age) noexcept;
/// The level for an estimate with this standard deviation [m]: valid, hold or land. For infinity
/// (no estimate) it is hold, and the age decides further.
FallbackLevel level_at(const LadderSigmas& sigmas, double sigma) noexcept;

/// The next level. Old data of partners make a robot hold and never land, since its own position is
/// still known.
/// @param by_sigma  best level that the standard deviations of estimates allow
FallbackLevel next_level(FallbackLevel now, const LadderTimes& times, const Ages& ages, bool on_ground,
                         FallbackLevel by_sigma = FallbackLevel::valid) noexcept;

// Search of a robot that is localized by vision and does not observe its target.
//
//   phase   condition                                     command
//   none    accepted sighting within `predict`            the plan
//   stand   no estimate, or sightings contradict it,      no motion: the body stays in view until
//           but a body is in view; also at the start      the filter starts or restarts
//   turn    as `stand`, with no body in view              no motion, a turn of `rate`, at first
//                                                         back against the last turn
//   sweep   no accepted sighting for longer than          up to `back_off` farther away, facing the
//           `predict`                                     target's estimate; from `sweep_from` on
//                                                         over 2 standard deviations to either side
//   round   as `sweep`, after `turn_after` of sweeping    the same place, a turn of `rate`
//
// The target's motion remains known from its broadcasts. The search runs after the supervisor: a
// robot on level `hold` turns in place, and one that lands is not changed. The barrier runs after
// the search and uses the true estimate.

struct SearchOptions {
  static constexpr std::string_view name = "search";

  double predict = 3.0;
  double back_off = 0.7;
  double sweep_from = 0.2;
  double rate = 1.0;
  double turn_after = 8.0;

  static constexpr auto parameters() {
    using O = SearchOptions;
    return Parameters{
        parameter("predict", &O::predict, "s", above_zero,
                  "without a view that the plan goes on, by the estimate and the target's broadcasts"),
        parameter("back_off", &O::back_off, "m", from_zero,
                  "farther from the target than it saw it, at most, where that is nearer than five standard "
                  "deviations of its "
                  "position"),
        parameter("sweep_from", &O::sweep_from, "rad", above_zero,
                  "standard deviation of the target's direction from which on the view sweeps"),
        parameter("rate", &O::rate, "rad/s", Bounds{0.05, 10.0, "0.05 to 10"}, "of a search's turn"),
        parameter("turn_after", &O::turn_after, "s", above_zero, "of sweeping; then it turns right round")};
  }
  bool operator==(const SearchOptions&) const = default;
  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
};

/// State of one robot's view.
struct View {
  static constexpr double never = -std::numeric_limits<double>::infinity();

  BodyId robot{}, target{};     ///< `target` is the body that it sighted last
  bool localized = false;       ///< its pose has an estimate
  double position_sigma = 0.0;  ///< standard deviation of its position [m]
  double bearing_sigma =
      0.0;                  ///< standard deviation of the target's direction, as estimated by the robot [rad]
  double accepted = never;  ///< stamp of the last sighting that its filter accepted [s]
  double sighted = never;   ///< stamp of the last sighting, accepted or not [s]
  double azimuth = 0.0;     ///< of the sensor's axis from the robot's heading, to the left [rad]
};

enum class SearchPhase : std::uint8_t { none, stand, turn, sweep, round };

/// Checks what the constructor of a Search checks.
void validate(const Team& team, std::span<const BodyId> robots, const SearchOptions& options);

/// Searches of all robots that are localized by vision. Throws and allocates only during
/// construction; never locks or prints.
class Search {
 public:
  /// Sightings that the filter refuses for longer than this are no outliers [s].
  static constexpr double contradicted_after = 0.2;
  /// For this time after the last sighting the target may still be in view [s].
  static constexpr double in_view = 0.3;
  static constexpr double fastest = 0.6;   ///< greatest speed towards the search position [m/s]
  static constexpr double approach = 1.0;  ///< time constant of this motion [s]

  /// @param robots  robots that are localized by vision
  /// @throws std::invalid_argument for options out of their range, and for a robot that cannot turn
  ///         in place
  Search(const Team& team, std::span<const BodyId> robots, const SearchOptions& options);
  Search(const Search&) = delete;  // its robots point into its team
  Search& operator=(const Search&) = delete;

  /// Takes the robots' views at t [s], in any order.
  /// @param x  estimated states of all bodies (nx)
  void look(double t, std::span<const View> views, std::span<const double> x) noexcept;
  /// Replaces the inputs of robots that search.
  /// @param x  states at which the commands take effect (nx)
  /// @param levels  of all bodies
  /// @param added  offset to the inputs (nu); the limits hold for the sum
  void command(double t, std::span<const double> x, std::span<const FallbackLevel> levels,
               std::span<const double> added, std::span<double> u) noexcept;
  /// Takes presence and limits from another membership.
  void follow(const Membership& now) noexcept;

  int robots() const noexcept { return static_cast<int>(robots_.size()); }
  BodyId robot(int i) const noexcept { return robots_[static_cast<std::size_t>(i)].body; }
  /// Phase of the i-th robot at the last look().
  SearchPhase phase(int i) const noexcept { return robots_[static_cast<std::size_t>(i)].phase; }

 private:
  struct Robot {
    BodyId body;
    std::size_t x, u, nx, nu;  // offsets and lengths
    Brake brake;
    const InputLimits* limits;
    std::vector<double> u_min, u_max;
    View view{};
    SearchPhase phase = SearchPhase::none;
    double since = View::never;                // time of the first view [s]
    double begun = 0.0;                        // start of the phase, or of the sweep to either side [s]
    double from = 1.0;                         // sense of the turn, 1 or -1
    double time = View::never, heading = 0.0;  // at the last look() [s], [rad]
    double turned = 0.0;                       // recent turn, to the left [rad]
    double distance_seen = 0.0;                // to the target at the last accepted sighting [m]
    Vec3<double> away{};                       // unit vector from the target to the search position
    bool contradicted = false, is_there = true;
  };
  static void follow_turn(Robot& robot, double t, double heading) noexcept;
  SearchPhase next(const Robot& robot, double t) const noexcept;
  Sight<double> sight(BodyId body, std::span<const double> x) const noexcept;
  double turn_rate(const Robot& robot, double t, const Sight<double>& own,
                   const Vec3<double>& target) const noexcept;

  Team team_;
  SearchOptions options_;
  std::vector<Robot> robots_;
  std::vector<double> u_rest_;
};

// State estimate of one body: accepts or refuses its measurements, and predicts its state to the
// present.
//
// A measurement x of time s is refused with the fault
//
//   not_finite    if one of its numbers is NaN or infinite
//   heading       if | |d| - 1 | > 0.05: it is not of unit length
//   world         if |p_x|, |p_y| or |p_z| > world
//   speed         if |v| > v_max
//   jump          if |p - p'| > v_max (s - s') + 3 sqrt(6) sigma, or the heading turned by more than
//                 turn_max (s - s') + 3 sqrt(2) sigma_heading, (p', s') being the previous one
//   frozen        if it was the same, bit for bit, for frozen_after, while the model under the given
//                 inputs has moved
//   time          if s is more than 50 ms ahead of now, or older than `oldest`
//
// (sqrt(6) sigma is the root mean square of the difference of two positions.) After a refusal, a
// measurement is accepted again after `accept_after` good ones in a row, each consistent with the
// previous one. The age of frozen measurements counts from the first of the equal ones.
//
// Between measurements the model predicts the state under the given inputs, so a late measurement
// is predicted to the present. A measurement of the present time is taken unchanged, bit for bit.

/// Reason why a measurement is refused.
enum class MeasurementFault : std::uint8_t { none, not_finite, heading, world, speed, jump, frozen, time };
inline constexpr int measurement_fault_count = 8;
std::string_view to_string(MeasurementFault fault);

/// Bounds of plausible measurements of a body.
struct TrackLimits {
  double world = 100.0;  ///< of a position, each axis [m], > 0
  double v_max = 5.0, turn_max = 4.0;
  double position_sigma = 0.0;  ///< of a measurement, each axis [m], >= 0
  double heading_sigma = 0.0;   ///< [rad], >= 0
  double frozen_after = 0.3;
  double oldest = 2.5;  ///< greatest age of a measurement that is predicted to the present [s], > 0
  int accept_after = 3;
  double command_delay = 0.0;  ///< from a command to its effect [s], >= 0

  static constexpr auto parameters() {
    using L = TrackLimits;
    return Parameters{
        parameter("v_max", &L::v_max, "m/s", above_zero, "greatest plausible speed of a body"),
        parameter("turn_max", &L::turn_max, "rad/s", above_zero, "greatest plausible turn rate of a body"),
        parameter("frozen_after", &L::frozen_after, "s", above_zero, "equal measurements are a fault then"),
        parameter("accept_after", &L::accept_after, "", {1, 1000, "1 to 1000"},
                  "good measurements in a row that clear a fault")};
  }
};

class Track {
 public:
  /// @param input_at  offset of the body's input in the history's rows
  Track(const Model& model, std::size_t input_at, const TrackLimits& limits);

  /// Takes a measurement x (nx) of time `stamp` that arrives at `now` [s]. Ignores one that is not
  /// newer than the last.
  /// @param sigma  standard deviation of an estimated position [m]; 0: measured. An estimate may
  ///               jump, since a new measurement corrects it
  /// @return why it is refused; `none` also for one that is ignored
  MeasurementFault take(std::span<const double> x, double stamp, double now, const InputHistory& history,
                        double sigma = 0.0) noexcept;
  /// Restarts the track for a body that joins at `now` [s] in the state x (nx). Earlier
  /// measurements are discarded.
  void begin(std::span<const double> x, double now) noexcept;
  /// Predicts the state to `now` [s], which must not decrease.
  void predict(double now, const InputHistory& history) noexcept;

  /// Whether a measurement was ever accepted; before, the state is at rest at the origin.
  bool known() const noexcept { return time_ > never; }
  /// Whether the last measurement was accepted.
  bool trusted() const noexcept { return trusted_; }
  /// The state estimate (nx) at the time of the last predict().
  std::span<const double> state() const noexcept { return x_; }
  /// Time of the measurement on which the state is based [s]; minus infinity before the first.
  double stamp() const noexcept { return stamp_; }

 private:
  static constexpr double never = -std::numeric_limits<double>::infinity();

  MeasurementFault implausible(std::span<const double> x) noexcept;
  bool consistent(const Sight<double>& sight, double stamp) const noexcept;
  bool frozen(std::span<const double> x, double stamp, const InputHistory& history) noexcept;
  void accept_measurement(std::span<const double> x, double stamp, double now) noexcept;
  void carry(std::vector<double>& x, double from, double to, const InputHistory& history) noexcept;

  Model model_;
  std::size_t input_at_;
  TrackLimits limits_;
  std::vector<double> x_, last_, drift_;  // estimate; last plausible measurement; prediction if frozen
  std::vector<double> scratch_, no_input_;
  double time_ = never, stamp_ = never;  // of x_; of the measurement on which it is based
  double last_stamp_ = never;            // youngest measurement so far
  double reference_stamp_ = never;       // of last_
  double equal_since_ = never, drift_time_ = never;
  Sight<double> sight_{}, reference_{};  // of the current measurement; of last_
  int streak_ = 0;                       // good measurements in a row since the last fault
  bool trusted_ = true, is_frozen_ = false;
};

// Fault handling: the state estimate of each body (Track), and fallback level and
// command of each robot.
//
//   accept_measurement()  takes a measurement with its times, returns the present state estimates
//   command()             scales or replaces the solvers' inputs by each robot's level
//   record()              stores the applied inputs for later predictions
//
// The caller calls these once in each period, in this order, and follow() before them if the team
// changes. A robot's partners are the bodies of all couplings and constraints that act on it. Its
// task requires their positions. Throws and allocates only during construction; never locks or
// prints.

struct SupervisorOptions {
  LadderTimes times{};
  LadderSigmas sigmas{};
  TrackLimits limits{};
  double slow_factor = 0.5, land_speed = 0.3, ground = 0.0, brake_time = 0.4;
  double period = 0.01;                  ///< shortest time between two commands [s]; sizes the input history
  std::vector<double> command_delays{};  ///< of each body, from a command to its effect [s]; empty: none

  static constexpr auto parameters() {
    using O = SupervisorOptions;
    return Parameters{
        parameter("slow_factor", &O::slow_factor, "", {0.0, 1.0, "0 to 1"},
                  "u* + slow_factor (u - u*) is applied when slowed"),
        parameter("land_speed", &O::land_speed, "m/s", above_zero, "downwards"),
        parameter("ground", &O::ground, "m", any_finite, "height where landing ends"),
        parameter("brake_time", &O::brake_time, "s", {0.05, std::numeric_limits<double>::max(), ">= 0.05"},
                  "time constant of the velocity in `hold` and `land`")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
};

/// An event of a body in this period: a robot changed its level, or a fault of its measurements
/// began.
struct Notice {
  BodyId body;
  std::variant<FallbackLevel, MeasurementFault> what;
};

/// Checks what the constructor of a Supervisor checks, and returns the options.
const SupervisorOptions& validate(const Team& team, const SupervisorOptions& options);

class Supervisor {
 public:
  /// @throws std::invalid_argument for options out of their range, and for a robot of more than 16
  ///         inputs
  Supervisor(const Team& team, const SupervisorOptions& options);
  Supervisor(const Supervisor&) = delete;  // its robots point into its team
  Supervisor& operator=(const Supervisor&) = delete;

  /// Updates the state estimate of all bodies at t [s].
  /// @param measured  states of all bodies as measured (nx)
  /// @param stamps  time of the measurement of each body [s]; unchanged: no new measurement
  /// @param sigma  of each body, standard deviation of an estimated position [m]; 0: measured;
  ///               infinity: unknown, then only states that do not depend on the position are
  ///               known. Empty: all are measured
  /// @return the estimated states of all bodies at t (nx), always finite, valid until the next call
  std::span<const double> accept_measurement(double t, std::span<const double> measured,
                                             std::span<const double> stamps,
                                             std::span<const double> sigma = {}) noexcept;
  /// Changes the inputs of robots that are slowed, hold, land or are grounded; afterwards all
  /// inputs are finite and within limits.
  /// @param x  states at which the commands take effect (nx)
  /// @param plan_ages  age of the plan of u for each body [s]; values of bodies that are no robots
  ///                   are ignored
  /// @param added  offset to the inputs (nu), such as wind compensation; the limits hold for the
  ///               sum
  /// @param u  inputs of all robots (nu)
  void command(double t, std::span<const double> x, std::span<const double> plan_ages,
               std::span<const double> added, std::span<double> u) noexcept;
  /// Records that u (nu) is applied from t [s] on.
  void record(double t, std::span<const double> u) noexcept { history_.record(t, u); }

  /// Takes presence, partners and limits from another membership. Absent bodies are not supervised.
  /// A body that joins starts anew on the level `valid`, as if measured at t.
  /// @param now  must outlive the next call; at first all bodies are present, coupled and limited
  ///             as in the team
  /// @param x  states of the bodies that join (nx)
  void follow(const Membership& now, double t, std::span<const double> x) noexcept;

  /// Events since the last call of accept_measurement().
  std::span<const Notice> notices() const noexcept { return notices_; }
  FallbackLevel level(BodyId robot) const noexcept { return robots_[robot_of_[at(robot)]].level; }
  /// Whether a measurement of each present body was accepted once.
  bool knows_all() const noexcept;
  /// Whether a robot is present that has no position and never had one.
  bool awaits_position() const noexcept;
  /// Whether the last measurement of a body was accepted.
  bool trusts(BodyId body) const noexcept { return tracks_[at(body)].trusted(); }
  /// Age of the body's state estimate at the last accept_measurement() [s]; infinity before the
  /// first measurement, 0 for an absent body.
  double age(BodyId body) const noexcept { return is_there(body) ? time_ - tracks_[at(body)].stamp() : 0.0; }

 private:
  struct Robot {
    BodyId body;
    std::size_t x, u, nx, nu;  // offsets and lengths
    std::vector<double> u_ref, u_min, u_max;
    std::vector<BodyId> partners;
    const InputLimits* limits;
    Brake brake;
    FallbackLevel level;
  };
  bool is_there(BodyId body) const noexcept { return presence_[at(body)] != Presence::absent; }
  FallbackLevel level_by_sigma(const Robot& robot) const noexcept;
  static std::vector<BodyId> partners_of(const Team& team, BodyId robot);

  Ages ages_of(const Robot& robot, std::span<const double> plan_ages) const noexcept;
  void apply(Robot& robot, std::span<const double> x, std::span<double> u) noexcept;
  void notify(const Notice& notice) noexcept;

  Team team_;
  SupervisorOptions options_;
  InputHistory history_;
  std::vector<Track> tracks_;
  std::vector<std::size_t> robot_of_;  // index into robots_ for each body; unused for other bodies
  std::vector<Robot> robots_;
  std::vector<Presence> presence_;
  std::vector<double> estimated_;
  std::vector<double> sigmas_;    // of each body, last received [m]
  std::vector<char> positioned_;  // whether its position was ever known since it joined
  std::vector<Notice> notices_;
  double time_ = 0.0;
};

}  // namespace sightline
