/// How targets and obstacles, which are not controlled, move in the simulated world.
///
/// Each motion gives the velocity that is held over the next step. A body without one keeps the velocity it
/// has.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/ocp/event/surroundings.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline {

/// On straight lines from point to point at one speed.
struct PathMotion {
  enum class End {
    rest,   ///< stays at the last point
    round,  ///< goes on to the first point, and round again
  };
  std::vector<Vec3<double>> points;  ///< [m], two or more
  double speed = 0.5;                ///< [m/s], > 0
  End end = End::rest;

  static constexpr std::string_view name = "path";
  void check() const;
};

/// On a level circle: centre + radius (cos a, sin a, 0), a = phase + rate t.
struct CircleMotion {
  Vec3<double> centre{};  ///< [m]
  double radius = 1.0;    ///< [m], >= 0
  double rate = 0.3;      ///< [rad/s]
  double phase = 0.0;     ///< [rad]

  static constexpr std::string_view name = "circle";
  void check() const;
};

/// Straight at the robot, as it is now; rests while it is nearer than the standoff.
struct ChaseMotion {
  AgentId agent{};
  double speed = 0.5;     ///< [m/s], > 0
  double standoff = 0.0;  ///< [m], >= 0

  static constexpr std::string_view name = "chase";
  void check() const;
};

/// Rests until a time, then flies straight on, once and for all, to pass `miss` to the left of the place
/// where it would meet the robot if that kept its velocity; of the place where the robot is, if it is too
/// slow to meet it.
struct CrossMotion {
  AgentId agent{};
  double at = 0.0;     ///< [s], >= 0
  double speed = 1.0;  ///< [m/s], > 0
  double miss = 0.0;   ///< [m], to the right where negative

  static constexpr std::string_view name = "cross";
  void check() const;
};

/// An obstacle carried by hand, as in section 7.3: rests out of the way until a time, then jumps to `from`
/// and approaches the robot, up to a standoff; where the robot evades, it follows.
struct HandMotion {
  AgentId agent{};
  double at = 15.0;       ///< [s], >= 0
  Vec3<double> from{};    ///< [m]
  double speed = 0.2;     ///< [m/s], > 0
  double standoff = 0.9;  ///< [m], >= 0

  static constexpr std::string_view name = "hand";
  void check() const;
};

/// Turns at intervals: with probability `aim` straight at the robot, else in a random direction; half of
/// the times at full speed, else at any speed below.
struct AdversaryMotion {
  enum class Within { plane, space };
  AgentId agent{};
  double speed = 1.5;  ///< most [m/s], > 0
  double every = 0.5;  ///< [s], >= 1e-3
  double aim = 0.5;    ///< in [0, 1]
  Within within = Within::plane;

  static constexpr std::string_view name = "adversary";
  void check() const;
};

using Motion = std::variant<PathMotion, CircleMotion, ChaseMotion, CrossMotion, HandMotion, AdversaryMotion>;

/// A body and how it moves.
struct BodyMotion {
  BodyId body{};
  Motion motion;
};

/// Where the motion begins, if it says so itself: on a path or a circle.
std::optional<Vec3<double>> start_of(const Motion& motion);
/// The speed it never exceeds [m/s].
double top_speed(const Motion& motion);

/// Moves the bodies of a team that are not its robots. Each has a stream of chance of its own.
class Motions {
 public:
  /// @throws std::invalid_argument where a parameter is out of its range, a body is a robot or moves twice, or
  /// one that is to be followed is no robot
  /// @param speed_max  as in PlantOptions
  Motions(const Team& team, std::vector<BodyMotion> motions, std::uint64_t seed,
          const std::vector<double>& speed_max = {});

  bool empty() const noexcept { return movers_.empty(); }

  /// Lets a body go from where it is in the stacked state x to a place, and rest there; the same move again changes nothing.
  void move(const Surroundings::Move& move, std::span<const double> x) noexcept;
  /// The body begins anew: no event moves it any more.
  void leave(BodyId body) noexcept;

  /// Sets the velocity of each body for the step from t to t + dt [s] in the stacked state x, and the place
  /// of one that enters at t. u are the inputs the robots have. Asked again at one time it does the same
  /// again; t must not fall. Allocates nothing.
  void steer(double t, double dt, std::span<const double> u, std::span<double> x) noexcept;

 private:
  struct Place {
    Model model;
    std::size_t x, u;  // offsets
  };
  struct Mover {
    Motion motion;
    std::size_t x;   // offset of p, then v
    Place followed;  // the robot, where there is one
    RandomStream chance;
    std::vector<double> lengths;  // of the path up to each point [m]
    Vec3<double> v{};             // chosen for longer than a step
    double next = 0.0;            // when it is to choose again [s]
    bool entered = false;
  };

  struct Steer;

  /// A body that an event moves, from `from` on; one for each target and obstacle.
  struct Carried {
    std::size_t x = 0;                                           // offset of p, then v
    double speed_max = std::numeric_limits<double>::infinity();  // [m/s]
    Surroundings::Move move{};
    Vec3<double> from{};
    double begun = std::numeric_limits<double>::quiet_NaN();  // the move that it was told last [s]
    bool moves = false;
  };

  std::vector<Mover> movers_;
  std::vector<Carried> carried_;
};

}  // namespace sightline
