/// Motions of targets and obstacles, which are not controlled, in the simulated world.
///
/// Each motion sets the velocity that is held over the next step. A body without a motion keeps its
/// velocity.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/ocp/surroundings.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline {

/// Straight lines from point to point at constant speed.
struct PathMotion {
  enum class End {
    rest,   ///< stays at the last point
    round,  ///< continues to the first point, and repeats
  };
  std::vector<Vec3<double>> points;  ///< [m], two or more
  double speed = 0.5;                ///< [m/s], > 0
  End end = End::rest;

  static constexpr std::string_view name = "path";
  void check() const;
};

/// Horizontal circle: centre + radius (cos a, sin a, 0), a = phase + rate t.
struct CircleMotion {
  Vec3<double> centre{};  ///< [m]
  double radius = 1.0;    ///< [m], >= 0
  double rate = 0.3;      ///< [rad/s]
  double phase = 0.0;     ///< [rad]

  static constexpr std::string_view name = "circle";
  void check() const;
};

/// Moves straight to the robot's current position; stops while it is closer than the standoff.
struct ChaseMotion {
  AgentId agent{};
  double speed = 0.5;     ///< [m/s], > 0
  double standoff = 0.0;  ///< [m], >= 0

  static constexpr std::string_view name = "chase";
  void check() const;
};

/// Rests until a time, then flies along one straight line that is not updated. The line passes
/// `miss` to the left of the point where the body would meet the robot at the robot's present
/// velocity. If the body is too slow to meet the robot, the line passes the robot's position
/// instead.
struct CrossMotion {
  AgentId agent{};
  double at = 0.0;     ///< [s], >= 0
  double speed = 1.0;  ///< [m/s], > 0
  double miss = 0.0;   ///< [m]; negative: to the right

  static constexpr std::string_view name = "cross";
  void check() const;
};

/// An obstacle carried by hand, as in section 7.3. It rests at its start until a time, then jumps
/// to `from` and approaches the robot up to a standoff. It follows a robot that evades.
struct HandMotion {
  AgentId agent{};
  double at = 15.0;       ///< [s], >= 0
  Vec3<double> from{};    ///< [m]
  double speed = 0.2;     ///< [m/s], > 0
  double standoff = 0.9;  ///< [m], >= 0

  static constexpr std::string_view name = "hand";
  void check() const;
};

/// Changes direction at intervals: straight to the robot with probability `aim`, else at random.
/// With probability 0.5 it moves at full speed, else at a uniformly drawn lower speed.
struct AdversaryMotion {
  enum class Within { plane, space };
  AgentId agent{};
  double speed = 1.5;  ///< maximum [m/s], > 0
  double every = 0.5;  ///< [s], >= 1e-3
  double aim = 0.5;    ///< in [0, 1]
  Within within = Within::plane;

  static constexpr std::string_view name = "adversary";
  void check() const;
};

using Motion = std::variant<PathMotion, CircleMotion, ChaseMotion, CrossMotion, HandMotion, AdversaryMotion>;

/// A body and its motion.
struct BodyMotion {
  BodyId body{};
  Motion motion;
};

/// Start position of a motion that defines one: a path or a circle.
std::optional<Vec3<double>> start_of(const Motion& motion);
/// Upper bound of the motion's speed [m/s].
double top_speed(const Motion& motion);

/// Moves the targets and obstacles of a team. Each has its own random stream.
class Motions {
 public:
  /// @throws std::invalid_argument if a parameter is out of its range, a body is a robot or has two
  /// motions, or a followed body is not a robot
  /// @param speed_max  as in PlantOptions
  Motions(const Team& team, std::vector<BodyMotion> motions, std::uint64_t seed,
          const std::vector<double>& speed_max = {});

  bool empty() const noexcept { return movers_.empty(); }

  /// Starts an event's move of a body, from its position in the stacked state x to a place where it
  /// then rests. A repeated call with the same move has no effect.
  void move(const Surroundings::Move& move, std::span<const double> x) noexcept;
  /// Ends the event's move of a body that starts again.
  void leave(BodyId body) noexcept;

  /// Sets the velocity of each body in the stacked state x for the step from t to t + dt [s]. Sets
  /// the position of a body that enters at t. Calls with equal t give equal results; t must not
  /// decrease. Allocates nothing.
  /// @param u  the inputs of the robots (nu), or empty
  void steer(double t, double dt, std::span<const double> u, std::span<double> x) noexcept;

 private:
  struct Place {
    Model model;
    std::size_t x, u;  // offsets
  };
  struct Mover {
    Motion motion;
    std::size_t x;   // offset of p, then v
    Place followed;  // the followed robot, if any
    RandomStream chance;
    std::vector<double> lengths;  // of the path up to each point [m]
    Vec3<double> v{};             // held for longer than a step
    double next = 0.0;            // time of its next change of direction [s]
    bool entered = false;
  };

  struct Steer;

  /// A body that an event moves, starting at `from`; one for each target and obstacle.
  struct Carried {
    std::size_t x = 0;                                           // offset of p, then v
    double speed_max = std::numeric_limits<double>::infinity();  // [m/s]
    Surroundings::Move move{};
    Vec3<double> from{};
    double begun = std::numeric_limits<double>::quiet_NaN();  // begin of the last move received [s]
    bool moves = false;
  };

  std::vector<Mover> movers_;
  std::vector<Carried> carried_;
};

}  // namespace sightline
