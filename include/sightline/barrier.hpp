/// Barrier: a filter that replaces a robot's command by the nearest one that keeps a hard distance.
///
/// A robot is safe if it has a plan that is safe for any motion of its neighbours. The plan is to
/// evade with a constant thrust, with the model's drag, at constant height and heading:
///
///   p_a(t) = p + E(t) v + F(t) a,   E = (1 - e^(-c t)) / c,   F = (c t - 1 + e^(-c t)) / c^2
///
/// At time t a neighbour is in a ball of centre c(t) and radius rho(t). The reserve (barrier value)
/// [m] is
///
///   B = max over a of min over t >= 0 of |p_a(t) - c(t)| - rho(t) - d_hard
///
/// so that the distance is at least d_hard + B, now and on the plan. The next sampled state follows
/// from the Runge-Kutta step of the plant. The filter requires B+ >= (1 - rate dt) B of it, against
/// the worst motion of the neighbour in between. The plan's own command satisfies this, so a robot
/// with B >= 0 always has a command, and B stays >= 0.
///
/// Against several uncooperative neighbours the filter requires the same of one plan against all,
/// which may climb or sink:
///
///   B = max over plans of min over neighbours and t >= 0 of |p_a(t) - c(t)| - rho(t) - d_hard
///
/// If no plan has B >= 0, the robot may be surrounded, and flies the best evasive trajectory
/// (EvasiveManeuver). If the vertical speed follows its command with one lag, p_z + tau v_z,
/// the height at which the robot would come to rest, replaces p_z, and |tau v_z| is added to rho.
///
/// A robot that drives along its heading brakes instead, and its braking path keeps the distances.
/// Against a body that moves at will it is safe in the passive sense: it stands before the body can
/// be nearer than d_hard, and cannot flee.
///
/// If the acceleration follows its command with a lag, the present one is part of p_a, and rho counts
/// what yaw rate and climb add until they settle.
///
/// If vehicles accelerate by up to w beyond their models, rho(t) contains w F(delay + t), or twice that
/// for a cooperative pair.
///
/// Floor, ceiling, world and zones have priority. docs/safety.md has the mathematics, and the
/// guarantee with its model and knowledge.
///
/// Units are SI, vectors in G. Constant after construction: one Barrier may serve many loops and
/// threads.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string_view>
#include <tuple>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/model.hpp"

namespace sightline {

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
  /// What the command of a cooperative neighbour lacks of its half, which this robot provides
  /// in addition [m]; < 0: what the neighbour provides beyond its half.
  double lacks = 0.0;
  Behavior behavior = Behavior::uncooperative;
};

/// A room that robots stay inside, or a forbidden zone that they stay outside: an upright prism.
struct Zone {
  enum class Keep { inside, outside };
  static constexpr std::array<std::string_view, 2> sides = {"inside", "outside"};
  static constexpr std::size_t most_corners = 64;

  /// Corners of a simple polygon, convex or not, in either orientation [m].
  std::vector<Vec2<double>> polygon{};
  double from = -std::numeric_limits<double>::infinity(),
         to = std::numeric_limits<double>::infinity();  ///< least and greatest height [m]
  Keep keep = Keep::outside;

  static constexpr auto parameters() {
    return Parameters{
        KeyText{"polygon", "[[x, y], ...]", "3 to 64 corners; edges neither cross nor touch [m]",
                "must be given"},
        KeyText{"keep", "one of inside, outside", "side of the prism that robots keep", "must be given"},
        KeyText{"from", "finite", "least height of the prism [m]", "none"},
        KeyText{"to", "> from", "greatest height of the prism [m]", "none"}};
  }
};

struct BarrierOptions {
  double floor = -std::numeric_limits<double>::infinity(), ceiling = std::numeric_limits<double>::infinity();
  double world = std::numeric_limits<double>::infinity();  ///< greatest |p_x| and |p_y| [m], > 0
  double margin = 0.002, wall_margin = 0.0;
  double rate = 4.0;       ///< greatest decay rate of the reserve [1/s], in (0, 1 / dt]
  double authority = 0.9;  ///< part of the acceleration that plans use, in (0, 1]; the rest is for wind
  /// Bound of the horizontal acceleration beyond the robots' models, such as wind [m/s^2], >= 0
  double residual_acceleration = 0.0;
  double command_delay = 0.0;   ///< from the measurement of a state to its command's effect [s], >= 0
  double velocity_sigma = 0.0;  ///< standard deviation of the robot's estimated velocity [m/s], >= 0
  double share = 0.5;           ///< part of a cooperative pair's reserve that this robot may use, in (0, 1]
  std::vector<Zone> zones{};    ///< all are kept

  static constexpr auto parameters() {
    using O = BarrierOptions;
    return Parameters{
        parameter("floor", &O::floor, "m", any_finite, "least height"),
        parameter("ceiling", &O::ceiling, "m", any_finite, "greatest height, > floor"),
        parameter(
            "residual_acceleration", &O::residual_acceleration, "m/s^2", from_zero,
            "bound of the horizontal acceleration beyond the robots' models; less than their plans have"),
        parameter("margin", &O::margin, "m", from_zero, "added to d_hard for the motion between samples"),
        parameter("wall_margin", &O::wall_margin, "m", from_zero,
                  "added to floor, ceiling, world and zones; a vehicle that climbs late needs 0.1 m")};
  }
};

/// The wall of a row of the filter; `none` for a row of a neighbour.
enum class Wall { none, floor, ceiling, x_min, x_max, y_min, y_max, zone };
std::string_view to_string(Wall wall) noexcept;

/// An evasive manoeuvre of a surrounded robot, and its predicted distance.
struct EvasiveManeuver {
  Vec2<double> along{};                                    ///< unit vector of G, or zero: no thrust
  double climb = 0.0;                                      ///< vertical speed [m/s]
  double wait = 0.0;                                       ///< before thrust and climb begin [s]
  double left = -std::numeric_limits<double>::infinity();  ///< least distance less the hard one [m]
  double within = 0.0;                                     ///< time below the hard distance [s]
  bool taken = false;  ///< flown in the previous period, and a candidate again
  /// Direction of the plan that certainly kept the distance to one neighbour after the previous
  /// period, and a candidate again; zero: none. For a tilt with a lag.
  Vec2<double> plan{};
};

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

/// Checks options for commands each dt [s] as the constructor of a Barrier does, and returns them.
const BarrierOptions& validate(const BarrierOptions& options, double dt);

struct Authority;  // accelerations and vertical speeds that the commands can produce
struct BarrierLaw;

class Barrier {
 public:
  /// Of more neighbours, those with the least distance left after 1 s of closing in count.
  static constexpr int most_neighbours = 16;
  /// Longest period of the commands for which the guarantee of docs/safety.md holds [s].
  static constexpr double longest_period = 0.5;

  /// @param u_min, u_max  limits of the inputs, the tightest of the flight
  /// @param dt  period of the commands, in (0, longest_period] [s]
  /// @throws std::invalid_argument for an option out of range, for a model of more than 4 inputs or
  ///         32 states, and for one that its commands neither push in every horizontal direction
  ///         nor drive along its heading
  Barrier(const Model& model, std::span<const double> u_min, std::span<const double> u_max, double dt,
          const BarrierOptions& options = {});
  /// @param can  abilities that plans use: those within the tightest limits, or less; push and rise
  ///             may be greater
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

  /// Whether height or tilt follow commands with a lag; then no robot can be its cooperative
  /// neighbour.
  bool lags() const noexcept;

  /// Whether the robot drives along its heading, and therefore brakes instead of fleeing. Its filter
  /// considers all given neighbours.
  bool drives() const noexcept;

  /// B of one neighbour at a state [m].
  double reserve(std::span<const double> x, const Neighbour& neighbour) const noexcept;
  /// Whether a plan keeps the distance to one neighbour: B >= 0, and for a tilt with a lag B >= 0 by a
  /// bound that holds between all times at which plans are evaluated.
  bool keeps(std::span<const double> x, const Neighbour& neighbour) const noexcept;
  /// What a command (nu) lacks of this robot's half of the distance to one cooperative neighbour [m], as
  /// Neighbour::lacks; 0 if the neighbour is far away.
  double lacked(std::span<const double> x, const Neighbour& neighbour, std::span<const double> u_min,
                std::span<const double> u_max, std::span<const double> u) const noexcept;

  /// Part of the acceleration that remains under these limits, relative to those of the
  /// construction; in [0.05, 1].
  double part(std::span<const double> u_min, std::span<const double> u_max) const noexcept;
  double acceleration() const noexcept;  ///< of plans [m/s^2]
  /// The options, bounds less their margins.
  const BarrierOptions& options() const noexcept;

 private:
  std::shared_ptr<const BarrierLaw> law_;
};

// Certified views: a filter that keeps a target in a sensor's region, docs/certified_view.md.

/// What is assumed of the target, of the measurements and of the air.
struct ViewBounds {
  double speed = 0.5;              ///< W, greatest horizontal speed of the target [m/s]
  double climb = 0.3;              ///< W_z, greatest vertical speed of the target [m/s]
  double acceleration = infinity;  ///< A, horizontal; finite: the target's velocity is measured [m/s^2]
  double age = 0.0;                ///< greatest age of the states of target and observer [s]
  double error = 0.0;              ///< greatest error of a measured position of the target [m]
  double spread = 0.0;             ///< distance from the known point to the farthest of several targets [m]
  double wind = 0.0;               ///< greatest horizontal acceleration by wind [m/s^2]

  static constexpr auto parameters() {
    using B = ViewBounds;
    constexpr Bounds age_range = {0.0, 2.0, "0 to 2"};
    return Parameters{
        parameter("speed_max", &B::speed, "m/s", from_zero, "greatest horizontal speed of the target"),
        parameter("climb_max", &B::climb, "m/s", from_zero, "greatest vertical speed of the target"),
        parameter("acceleration_max", &B::acceleration, "m/s^2", above_zero,
                  "greatest horizontal acceleration of a target whose velocity is measured"),
        parameter("age", &B::age, "s", age_range,
                  "greatest age of the measured states of target and observer"),
        parameter("error", &B::error, "m", from_zero, "greatest error of a measured position of the target"),
        parameter("spread", &B::spread, "m", from_zero, "greatest distance of further targets from this one"),
        parameter("wind", &B::wind, "m/s^2", from_zero, "greatest horizontal acceleration by wind")};
  }

  bool is_velocity_measured() const { return acceleration < infinity; }
  /// The point that the filter follows: how fast it moves, and how far the target is from it.
  struct Known {
    double speed, climb, radius, height;
  };
  /// An estimate that follows measurements no faster than 1.2 W stays within `radius` of the target.
  Known known(double dt) const;
};

/// A reserve of the set in which a view is certified, or another condition.
enum class ViewReserve {
  near,      ///< distance, with the distance to brake
  far,       ///< the same of the greatest distance
  left,      ///< bearing of the target
  right,     ///< the same on the other side
  high,      ///< height above the target
  low,       ///< the same of the least height
  sideward,  ///< sideward speed; of robots with lags, also vertical speed and yaw rate
  command,   ///< no command within the present limits, or none that other limits leave, keeps the set
  age,       ///< a measurement is older than ViewBounds::age, or missing, or not predicted to now
  error,     ///< three standard deviations of the estimated positions exceed ViewBounds::error
  speed,     ///< the target was faster than ViewBounds::speed or climb
  motion,    ///< the robot moved otherwise than its model and ViewBounds::wind allow
};
std::string_view to_string(ViewReserve reserve) noexcept;

class ViewFilter;  // keeps the set of one certificate

}  // namespace sightline
