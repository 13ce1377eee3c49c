/// The barrier, a filter that keeps a hard distance by the least change of a command, and its evasive maneuvers.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"
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

// The accelerations and vertical speeds that a robot's commands can produce, found from its model.
//
// The horizontal velocity v follows
//
//   v' = -c v + a     for every a of a disc |a| <= b, and for every corner a = sum of +-g_k,
//                     at every speed that the robot reaches by its own commands
//
// c is the drag fitted over all directions. Where drag differs between directions, the thrust that
// compensates the difference is subtracted from b and g_k. For the multirotor, (16):
// c = -a_f, b = b_f, since along an axis one command alone accelerates it, and g_k = (b_f, 0),
// (0, b_s) in V.

inline constexpr int most_states = 32;  ///< of a robot with an Authority

struct Authority {
  double drag = 0.0;                      ///< c [1/s], >= 0
  double acceleration = 0.0;              ///< b [m/s^2], > 0
  std::array<Vec2<double>, 4> thrusts{};  ///< g_k [m/s^2]
  int thrust_count = 0;
  bool turns = false;   ///< g_k are in V and turn with the heading; else in G
  bool climbs = false;  ///< commands change the height
  /// tau of a vertical speed with a lag, v_z' = (b u - v_z) / tau; 0: no lag [s]
  double climb_lag = 0.0;
  double climb = 0.0;             ///< vertical speed attainable both up and down [m/s]
  std::array<double, 4> reach{};  ///< half range of each input; 0: it neither pushes nor climbs
  double push = 0.0;              ///< greatest |v' + c v| under any command [m/s^2]
  double rise = 0.0;              ///< greatest vertical speed of a robot without a lag, up or down [m/s]
  double free = 1.0;              ///< part of the inputs' push that compensates nothing else, in (0, 1]

  /// Part of b, g_k and climb that remains under narrower input limits, in [0.05, 1].
  double part(std::span<const double> u_min, std::span<const double> u_max) const noexcept;
};

/// Whether two robots have like motion and differ only in the size of their abilities. Only then
/// can each rely on the other's use of the same law.
bool moves_alike(const Authority& a, const Authority& b) noexcept;

/// @param u_min, u_max  limits of the inputs, finite
/// @throws std::invalid_argument for a model of more than 4 inputs or 32 states. Also for a model
///         whose commands do not accelerate it in every horizontal direction at once and along axes
///         of its heading or of G. Also for a model whose height follows its command neither at
///         once nor with one lag
Authority authority_of(const Model& model, std::span<const double> u_min, std::span<const double> u_max);

// The best evasive plan against one neighbour, and the distance that it leaves: see barrier.hpp.
//
// Relative to the centre of the neighbour's ball, a robot that evades with acceleration a is at
//
//   q_a(t) = r + E(t) w + F(t) a - t g,     r = p - c(0)
//
// plus the height that the plan climbs, if it does. w is the robot's horizontal velocity, g the
// velocity of the centre.
//
// The neighbour is within rho(t) = rho0 + speed t + growth t^2 / 2 + spread E(t) of the
// centre. The search maximises the least f_a(t) = |q_a(t)| - rho(t) over a in a disc |a| <= beta,
// or over the corners sum of +-g_k of the thrusts g_k. At a given t the best a is the one farthest
// along q_0(t) = r + E w - t g, so
//
//   max over a of min over t of f_a  <=  min over t of max over a of f_a
//
// The a of the t that is least on the right is the optimum if both sides are equal, which is
// checked. If not (two plans are equally good), all corners are tried, or gradient ascent improves
// the disc's a, from it and from the direction straight away.

/// A neighbour's ball and the robot's motion for a plan. S may be a pack of numbers, for several
/// tubes at once.
template <class S>
struct TubeOf {
  Vec3<S> r{};      ///< from the centre to the robot [m]
  Vec2<S> w{};      ///< velocity subject to drag: of the robot, relative to a cooperative neighbour [m/s]
  Vec3<S> drift{};  ///< velocity of the centre [m/s]
  S climb{};        ///< vertical speed of the robot [m/s], until its height has
  S room{};         ///< changed by this much [m], >= 0
  S beta{};         ///< radius of the disc [m/s^2], used without thrusts
  std::array<Vec2<S>, 4> thrusts{};  ///< g_k [m/s^2]
  int thrust_count = 0;
  S rho0{};                     ///< [m]
  S speed{};                    ///< [m/s]
  S growth{};                   ///< [m/s^2]
  S spread{};                   ///< [m/s]
  Vec2<S> tie{S(1.0), S(0.0)};  ///< evasive direction if no other is defined
};
using Tube = TubeOf<double>;

/// e^(-c t), E and F at one time t.
template <class S>
struct EscapeShapeOf {
  S e, E, F;
};
using EscapeShape = EscapeShapeOf<double>;

/// The gap of a plan at one time.
struct Touch {
  double gap;         ///< f_a(t) [m]
  double time;        ///< t [s], >= dt
  Vec3<double> n;     ///< from the centre to the robot
  EscapeShape shape;  ///< at t
  bool level;         ///< the plan has climbed or sunk by its full room
  double slope;       ///< f_a'(t) [m/s]
  double curvature;   ///< f_a''(t) [m/s^2]
};

struct Escape {
  double now;      ///< least f_a(t) over 0 <= t < dt, at times at most longest_part apart [m]
  Vec2<double> a;  ///< acceleration of the plan [m/s^2]
  /// The least f_a(t) over t >= dt, and another minimum within 0.1 m of it.
  std::array<Touch, 2> touches;
  std::size_t count;  ///< number of touches

  double later() const { return touches[0].gap; }
  /// B [m].
  double reserve() const { return now < later() ? now : later(); }
};

/// A candidate plan: an acceleration [m/s^2], and a vertical speed [m/s] until the height has
/// changed by room [m].
struct EscapeFlight {
  Vec2<double> a;
  double climb = 0.0, room = 0.0;
};

/// Searches for plans. Does not throw; allocates only during construction. The tubes of one call
/// are those of several neighbours of one robot, with the same thrusts. The results equal those of
/// single calls, bit for bit.
class EscapePlans {
 public:
  using Tubes = std::span<const Tube* const>;

  /// Longest sampling step within a period; the deviation between samples is less than 1 mm [s].
  static constexpr double longest_part = 0.01;
  static constexpr int most_parts = 50;
  /// Number of steps in a period of dt [s].
  static int parts(double dt) noexcept;

  EscapePlans() = default;
  /// @param drag  c [1/s], >= 0
  /// @param dt    period [s], at most most_parts longest_part
  EscapePlans(double drag, double dt);

  /// The best plan at constant height.
  Escape best(const Tube& tube) const noexcept;
  void best(Tubes tubes, std::span<Escape* const> plans) const noexcept;
  /// The plan with one acceleration.
  Escape with(const Tube& tube, const Vec2<double>& a) const noexcept;
  /// The plans of one flight. @return false if a plan leaves less than `wanted` [m], now or at a
  /// time of the grid; then not all plans are found. Values on the grid exceed the reserve, mostly
  /// by less than 0.1 m
  bool with(Tubes tubes, const EscapeFlight& flight, double wanted, std::span<Escape> plans) const noexcept;
  Touch touch(const Tube& tube, const Vec2<double>& a, double t) const noexcept;

  double E(double t) const noexcept;
  double F(double t) const noexcept;
  double E_longest() const noexcept { return E_[times - 1]; }  ///< at the end of all plans [s]
  EscapeShape shape(double t) const noexcept;
  /// Shape of the rest of the plan after the next sample, at touch.time - dt.
  EscapeShape left(const Touch& touch) const noexcept;

 private:
  static constexpr std::size_t times = 24;
  static constexpr double longest = 8.0;  // [s]
  template <class S>
  struct Search;

  template <class S>
  EscapeShapeOf<S> shape_at(S t) const noexcept;
  /// Calls visit(search, first, count) for packs of tubes, until it returns false.
  template <class Visit>
  void in_packs(Tubes tubes, double climb, double room, Visit visit) const noexcept;
  /// The best of all candidates, for a plan that the search has not proven optimal.
  Escape best_of_all(const Search<double>& search, const Escape& plan) const noexcept;

  double c_ = 0.0, per_c_ = 0.0, dt_ = 0.0, e_back_ = 1.0;
  std::array<double, times> t_{}, E_{}, F_{};
  // At the times within the period.
  std::size_t between_ = 0;
  std::array<double, most_parts - 1> t_between_{}, E_between_{}, F_between_{};
};

// Evasive trajectories for a surrounded robot: no plan is safe under every motion of the bodies.
//
// A manoeuvre is open loop: wait, then full thrust in one direction of G and one vertical speed,
// up to the ceiling or down to the floor. It is simulated against bodies that pursue the robot,
// each straight at it at its own speed. Its value is the least distance over the next 6 s minus
// the hard distance. The best of a fixed set, of the previous manoeuvre and of its variations is
// taken.
//
// Against bodies that do pursue in this way the distance is never less than predicted, since the
// rest of a plan is a plan. Against others there is no guarantee.
//
// Allocates nothing, and is constant: the caller stores the manoeuvre.

/// A manoeuvre and its predicted distance.
struct EvasiveManeuver {
  Vec2<double> along{};                                    ///< unit vector of G, or zero: no thrust
  double climb = 0.0;                                      ///< vertical speed [m/s]
  double wait = 0.0;                                       ///< before thrust and climb begin [s]
  double left = -std::numeric_limits<double>::infinity();  ///< least distance less the hard one [m]
  double within = 0.0;                                     ///< time below the hard distance [s]
  bool taken = false;  ///< flown in the previous period, and a candidate again
};

/// A body in the simulation of a manoeuvre.
struct Chaser {
  Vec3<double> p{};    ///< [m]
  Vec3<double> v{};    ///< velocity of a body that flies straight on [m/s]
  double speed = 0.0;  ///< speed at which it pursues the robot [m/s]
  double hard = 0.0;   ///< hard distance [m]
};

/// The robot's state, thrusts and bounds.
struct Arena {
  Vec3<double> p{};                 ///< [m]
  Vec2<double> v{};                 ///< horizontal velocity [m/s]
  std::array<Vec2<double>, 2> g{};  ///< two thrusts of G that add up [m/s^2]; zero: `disc` in any direction
  double disc = 0.0;                ///< radius of accelerations [m/s^2]
  double floor = 0.0, ceiling = 0.0, world = 0.0;  ///< [m]
};

class EvasiveManeuvers {
 public:
  EvasiveManeuvers() = default;
  /// @param drag   c [1/s], >= 0
  /// @param climb  greatest vertical speed both ways [m/s], >= 0
  EvasiveManeuvers(double drag, double climb);

  /// The best manoeuvre. Stops at a manoeuvre that leaves `enough` [m], which may not be the best.
  /// @param before  the previous manoeuvre, less the time since; tried first
  EvasiveManeuver best(const Arena& arena, std::span<const Chaser> chasers, const EvasiveManeuver& before,
                       double enough) const noexcept;
  /// The least distance of a manoeuvre, less the hard distance [m].
  double left(const Arena& arena, std::span<const Chaser> chasers,
              const EvasiveManeuver& plan) const noexcept;

  /// Greatest acceleration along a unit vector, as a vector [m/s^2].
  static Vec2<double> thrust(const Arena& arena, const Vec2<double>& along) noexcept;

  static constexpr std::size_t headings = 16;
  /// Unit vectors of the fixed set.
  static Vec2<double> heading(std::size_t i) noexcept;

 private:
  using Pack = NativeLane;
  static constexpr std::size_t width = Pack::width;
  void judge(const Arena& arena, std::span<const Chaser> chasers,
             std::span<EvasiveManeuver, width> plans) const noexcept;

  struct Step {
    double h = 0.0, e = 1.0, E = 0.0,
           F = 0.0;  // [s]; decay of the velocity; effects of a velocity and an acceleration
  };
  Step fine_, coarse_;
  double climb_ = 0.0;
  std::array<Vec2<double>, headings> heading_{};
};

// Barrier: a filter that replaces a robot's command by the nearest one that keeps a hard distance.
//
// A robot is safe if it has a plan that is safe for any motion of its neighbours. The plan is to
// evade with a constant thrust, with the model's drag, at constant height and heading:
//
//   p_a(t) = p + E(t) v + F(t) a,   E = (1 - e^(-c t)) / c,   F = (c t - 1 + e^(-c t)) / c^2
//
// At time t a neighbour is in a ball of centre c(t) and radius rho(t). The reserve (barrier value)
// [m] is
//
//   B = max over a of min over t >= 0 of |p_a(t) - c(t)| - rho(t) - d_hard
//
// so that the distance is at least d_hard + B, now and on the plan. The next sampled state follows
// from the Runge-Kutta step of the plant. The filter requires B+ >= (1 - rate dt) B of it, against
// the worst motion of the neighbour in between. The plan's own command satisfies this, so a robot
// with B >= 0 always has a command, and B stays >= 0.
//
// Against several uncooperative neighbours the filter requires the same of one plan against all,
// which may climb or sink:
//
//   B = max over plans of min over neighbours and t >= 0 of |p_a(t) - c(t)| - rho(t) - d_hard
//
// If no plan has B >= 0, the robot may be surrounded, and flies the best evasive trajectory
// (EvasiveManeuver). If the vertical speed follows its command with one lag, p_z + tau v_z,
// the height at which the robot would come to rest, replaces p_z, and |tau v_z| is added to rho.
//
// Floor, ceiling and world have priority. docs/safety.md has the mathematics, and the guarantee
// with its model and knowledge.
//
// Units are SI, vectors in G. Constant after construction: one Barrier may serve many loops and
// threads.

/// Assumption about a neighbour.
enum class Behavior {
  uncooperative,  ///< moves in any direction at up to speed_max, turns at will; does not give way
  cooperative,    ///< runs the same Barrier against this robot and takes the other share; same model
};

/// Another body, as known to this robot.
struct Neighbour {
  Vec3<double> p{};        ///< position [m]
  Vec3<double> v{};        ///< velocity [m/s]; if uncooperative, for manoeuvres and acceleration_max
  double d_hard = 1.0;     ///< centre to centre [m], > 0
  double speed_max = 1.5;  ///< of an uncooperative neighbour [m/s], >= 0; 0: at rest
  double acceleration_max =
      std::numeric_limits<double>::infinity();  ///< of an uncooperative neighbour [m/s^2], >= 0
  double age = 0.0;                             ///< of p and v [s], >= 0
  double sigma = 0.0;  ///< standard deviation of the position relative to the robot [m]; 3 sigma are added
  double part = 1.0;   ///< of a cooperative neighbour: part of its acceleration within its limits, in [0, 1]
  double tie = 1.0;    ///< if both are in one place, the robot evades along tie x; of opposite sign
                       ///< for the two members of a pair
  Behavior behavior = Behavior::uncooperative;
};

struct BarrierOptions {
  double floor = -std::numeric_limits<double>::infinity();   ///< least height [m]
  double ceiling = std::numeric_limits<double>::infinity();  ///< greatest height [m], > floor
  double world = std::numeric_limits<double>::infinity();    ///< greatest |p_x| and |p_y| [m], > 0
  double margin = 0.002;        ///< added to d_hard for the motion between two samples [m], >= 0
  double wall_margin = 0.0;     ///< distance to floor, ceiling and world, for a height with a lag [m], >= 0
  double rate = 4.0;            ///< greatest decay rate of the reserve [1/s], in (0, 1 / dt]
  double authority = 0.9;       ///< part of the acceleration that plans use, in (0, 1]; the rest is for wind
  double velocity_sigma = 0.0;  ///< standard deviation of the robot's estimated velocity [m/s], >= 0
  double share = 0.5;           ///< part of a cooperative pair's reserve that this robot may use, in (0, 1]
};

/// The wall of a row of the filter; `none` for a row of a neighbour.
enum class Wall { none, floor, ceiling, x_min, x_max, y_min, y_max };
std::string_view to_string(Wall wall) noexcept;

struct BarrierResult {
  bool active = false;  ///< the command was changed
  bool conflict =
      false;  ///< no command within the limits keeps all, or no manoeuvre is safe; least violation
  double violation = 0.0;  ///< largest amount by which a row, or the manoeuvre's distance, is missed [m];
                           ///< 0 without a conflict
  /// Least B of all neighbours [m]; with a plan for several uncooperative neighbours, that of the
  /// plan.
  double reserve = std::numeric_limits<double>::infinity();
  bool surrounded = false;  ///< no plan is safe under every motion of the uncooperative neighbours
  int neighbour = -1;       ///< index of the neighbour with the tightest row, or -1
  Wall wall = Wall::none;   ///< wall of the tightest row, if that is not a neighbour's
};

/// Checks the options for commands each dt [s] as the constructor of a Barrier does, and returns them.
const BarrierOptions& validate(const BarrierOptions& options, double dt);

class Barrier {
 public:
  /// Of more neighbours, those with the least distance left after 1 s of closing in count.
  static constexpr int most_neighbours = 16;
  /// Longest period of the commands for which the guarantee of docs/safety.md holds [s].
  static constexpr double longest_period = 0.5;

  /// @param u_min, u_max  limits of the inputs, the tightest of the flight
  /// @param dt  period of the commands, in (0, longest_period] [s]
  /// @throws std::invalid_argument for an option out of range, and for a model that authority_of()
  ///         refuses
  Barrier(const Model& model, std::span<const double> u_min, std::span<const double> u_max, double dt,
          const BarrierOptions& options = {});
  /// @param can  abilities that plans use: those of authority_of() within the tightest limits, or
  ///             less; push and rise may be greater
  Barrier(const Model& model, const Authority& can, double dt, const BarrierOptions& options = {});

  /// Replaces u by the nearest command that keeps all distances and walls. Allocates nothing.
  /// Ignores a neighbour with numbers that are not finite, and reports a conflict.
  /// @param x  estimated state of the robot (nx)
  /// @param u_min, u_max  present limits (nu); plans use the part that they leave of the limits of
  ///                the construction
  /// @param u  the solver's command (nu); afterwards always finite and within the limits
  /// @param maneuver  evasive manoeuvre of a surrounded robot; the caller keeps it between periods
  BarrierResult filter(std::span<const double> x, std::span<const Neighbour> neighbours,
                       std::span<const double> u_min, std::span<const double> u_max, std::span<double> u,
                       EvasiveManeuver& maneuver) const noexcept;
  /// The same without a manoeuvre of the previous period.
  BarrierResult filter(std::span<const double> x, std::span<const Neighbour> neighbours,
                       std::span<const double> u_min, std::span<const double> u_max,
                       std::span<double> u) const noexcept {
    EvasiveManeuver none;
    return filter(x, neighbours, u_min, u_max, u, none);
  }

  /// Whether the height follows commands with a lag; then no robot can be its cooperative
  /// neighbour.
  bool climbs_late() const noexcept { return can_.climb_lag > 0; }

  /// B of one neighbour at a state [m].
  double reserve(std::span<const double> x, const Neighbour& neighbour) const noexcept;

  /// Part of the acceleration that remains under these limits, relative to those of the
  /// construction; in [0.05, 1].
  double part(std::span<const double> u_min, std::span<const double> u_max) const noexcept {
    return can_.part(u_min, u_max);
  }
  const BarrierOptions& options() const noexcept { return options_; }
  double acceleration() const noexcept { return b_; }  ///< b [m/s^2], used by plans
  double drag() const noexcept { return can_.drag; }   ///< c [1/s]

 private:
  struct Next;
  struct Threat;
  struct Row;
  struct Rows;
  struct Joint;
  struct Linear;
  struct Within;
  struct Flown;
  enum class Heeded { all, members };
  enum class Approach { slowing, at_once };  // of floor and ceiling

  Next next(std::span<const double> x, std::span<const double> u) const noexcept;
  void fill(Tube& tube, const Sight<double>& self, const Neighbour& neighbour, double part,
            double beside) const noexcept;
  /// Adds the chosen neighbours with their plans.
  void add_threats(const Sight<double>& self, std::span<const Neighbour> neighbours,
                   std::span<const int> chosen, Rows& rows) const noexcept;
  Within within(const Tube& tube) const noexcept;
  Sight<double> settled(Sight<double> self) const noexcept;
  Row keep_away(const Sight<double>& self, const Rows& rows, int threat, const Touch& touch) const noexcept;
  bool find_threats(const Sight<double>& self, std::span<const Neighbour> neighbours,
                    Rows& rows) const noexcept;
  /// Finds one plan for all uncooperative neighbours. @return its reserve [m]; infinity if the
  /// single plans suffice, minus infinity if there is no plan
  double join(const Sight<double>& self, Rows& rows) const noexcept;
  bool is_surrounded(const Sight<double>& self, std::span<const Neighbour> neighbours,
                     const Rows& rows) const noexcept;
  Arena arena(const Sight<double>& self, double part) const noexcept;
  bool leave(const Sight<double>& self, const Next& after, bool contradicted,
             std::span<const Neighbour> neighbours, const Rows& rows,
             EvasiveManeuver& maneuver) const noexcept;
  void follow(std::span<const double> x, const Sight<double>& self, EvasiveManeuver& maneuver,
              std::span<const double> u_min, std::span<const double> u_max,
              std::span<double> u) const noexcept;
  void reach_for(std::span<const double> x, const std::array<double, 3>& wanted,
                 std::span<const double> u_min, std::span<const double> u_max,
                 std::span<double> u) const noexcept;
  double required(const Threat& threat) const noexcept;
  Flown flown(std::span<const double> x, std::span<const double> u) const noexcept;
  double left_by(const Sight<double>& self, const Rows& rows, const Flown& flown) const noexcept;
  double left_of_pair(const Sight<double>& self, const Threat& threat, const Flown& flown) const noexcept;
  double left_of_chases(const Sight<double>& self, const Rows& rows, const Flown& flown) const noexcept;
  double left_of_walls(const Sight<double>& self, double part, const Flown& flown) const noexcept;
  double stopping_time(double away, double part) const noexcept;
  double braked(const Vec2<double>& n, const Vec3<double>& p, const Vec2<double>& v,
                double part) const noexcept;
  template <class Left>
  double towards_plan(std::span<const double> x, const Sight<double>& self, const Vec2<double>& a,
                      double rise, std::span<const double> u_min, std::span<const double> u_max,
                      std::span<double> u, const Left& left) const noexcept;
  void ensure_walls(std::span<const double> x, const Sight<double>& self, const Rows& rows,
                    std::span<const double> u_min, std::span<const double> u_max, std::span<double> u,
                    Next& after) const noexcept;
  bool ensure_distances(std::span<const double> x, const Sight<double>& self, const Rows& rows,
                        std::span<const double> u_min, std::span<const double> u_max, std::span<double> u,
                        Next& after) const noexcept;
  void add_neighbours(const Sight<double>& self, Heeded heeded, Rows& rows) const noexcept;
  void add_walls(const Sight<double>& self, Approach approach, Rows& rows) const noexcept;
  void add_cuts(const Sight<double>& self, const Next& there, Rows& rows) const noexcept;
  double solve(std::span<const double> x, const Sight<double>& self, const Next& nominal, Rows& rows,
               std::span<const double> u_min, std::span<const double> u_max,
               std::span<double> u) const noexcept;

  Model model_;
  BarrierOptions options_;
  double dt_;
  int parts_;  // integration steps of a period
  Authority can_;
  double b_;
  EscapePlans plans_;
  double ample_;  // [m] upper bound on the loss of a plan's reserve in a period
  EvasiveManeuvers maneuvers_;
  std::array<Vec2<double>, EvasiveManeuvers::headings>
      joint_;  // thrusts of plans for several, in V or G [m/s^2]
};

// Selects the few bodies that threaten a robot most, so that its barrier considers these alone.
//
//   key = |r| - d_hard + r . w / |r| - speed,     r = p - p_j [m]
//
// with w = v - v_j and speed = 0 if j is cooperative, else w = v and speed = speed_max [m/s].
//
// The key is the distance left after 1 s of closing in. Columns of all bodies are contiguous, so
// that the keys are computed in SIMD lanes. A barrier that receives all bodies selects the same
// ones, in the same order.

/// Distance that remains of r after 1 s at velocity w, less d_hard and the body's own speed [m].
inline double nearest_threats_key(const Vec3<double>& r, const Vec3<double>& w, double d_hard,
                                  double speed) noexcept {
  const double D = std::sqrt(dot(r, r)), length = D > 1e-9 ? D : 1e-9;
  return length - d_hard + dot(r, w) / length - speed;
}

/// Selection among the bodies of one period. clear(), add() and nearest_threats() do not allocate.
class ThreatSelection {
 public:
  struct Body {
    int id;
    Vec3<double> p, v;  // [m], [m/s]
    double d_hard;      // [m]
    double speed_max;   // of an uncooperative body [m/s]
  };

  /// Input and work space of one request; several threads may each use their own.
  class Requester {
   public:
    explicit Requester(int bodies);

    /// For each added body, in that order: 1 if it is cooperative to the robot of the request, else
    /// 0.
    std::vector<double> cooperative;

   private:
    friend class ThreatSelection;
    std::vector<int> chosen_;
    std::vector<double> key_, chosen_key_;
  };

  /// @param bodies  capacity
  explicit ThreatSelection(int bodies);

  void clear() noexcept { count_ = 0; }
  void add(const Body& body) noexcept;
  int size() const noexcept { return static_cast<int>(count_); }
  int id(int i) const noexcept { return ids_[static_cast<std::size_t>(i)]; }

  /// The ids of the `most` bodies with the least keys, in ascending order, then of all bodies with
  /// a key that is not finite.
  /// @param p, v  position [m] and velocity [m/s] of the robot `self`, which is excluded
  /// @param requester  cooperation of the bodies; holds the result until its next request
  std::span<const int> nearest_threats(int self, const Vec3<double>& p, const Vec3<double>& v,
                                       std::size_t most, Requester& requester) const noexcept;

 private:
  std::size_t count_ = 0;
  std::vector<int> ids_;
  std::vector<double> p_x_, p_y_, p_z_, v_x_, v_y_, v_z_, hard_, speed_;
};

}  // namespace sightline
