/// The plant of the simulated world: the continuous models of all bodies, with disturbances.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sightline/base/integrate.hpp"
#include "sightline/base/thread_pool.hpp"
#include "sightline/ocp/active_team.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/downwash.hpp"
#include "sightline/world/motion.hpp"

namespace sightline {

/// Dynamics that replace the models of some robots of a plant: rigid bodies with rotors, or another
/// simulator. Nothing here allocates, locks or throws.
///
/// A step: steer() for each robot that is present, move() once for all, show() for each.
class RobotDynamics {
 public:
  virtual ~RobotDynamics() = default;
  /// Whether these dynamics move this robot; constant over time.
  virtual bool moves(BodyId robot) const noexcept = 0;
  /// From t [s] on the robot is in the state x of its model: at the start, and whenever it joins
  /// again.
  virtual void begin(BodyId robot, double t, const double* x) noexcept = 0;
  /// Sets the robot's inputs u and the acceleration in G [m/s^2] that wind, gusts and wakes give
  /// its model. Both are held over the next move().
  virtual void steer(BodyId robot, const double* u, const Vec3<double>& acceleration) noexcept = 0;
  /// Moves the steered robots on to t [s]; the others rest.
  virtual void move(double t) noexcept = 0;
  /// Writes the state x of the robot's model.
  virtual void show(BodyId robot, double* x) const noexcept = 0;
  /// Replaces the entries of the true state x that the robot measures itself, with their errors.
  virtual void sense(BodyId /*robot*/, double* /*x*/) const noexcept {}
};

struct PlantOptions {
  std::uint64_t seed = 1;
  Disturbances disturbances{};
  double period = 0.01;               ///< shortest step [s]; sizes the queue of delayed commands
  std::vector<BodyMotion> motions{};  ///< of targets and obstacles; others keep their velocity
  /// Speed limits of targets and obstacles that events move, in team order [m/s]; 0 or empty: no
  /// limit.
  std::vector<double> speed_max{};
  RobotDynamics* dynamics = nullptr;  ///< of the robots that it moves; must outlive the plant
  DownwashOptions downwash{};         ///< of vehicles; for `dynamics`
  /// Threads that share the work from `shared_from` bodies or `vehicles_shared_from` vehicles on.
  /// Null: the caller's thread only. The result does not depend on it.
  std::shared_ptr<ThreadPool> pool{};
  static constexpr int shared_from = 256, vehicles_shared_from = 16;
};

/// Integrates x' = f(x, u) of each body by classical Runge-Kutta steps with u held (zero-order
/// hold). After each step every heading is normalised. An undisturbed step is one Runge-Kutta step
/// of each model, bit for bit, unless a fast model needs shorter ones (part_of_fastest).
///
/// Wind, gusts and wakes are accelerations of the robots, held over a step. A delayed command that
/// comes into force within a step divides the step there. Targets and obstacles with a motion hold
/// its velocity over a step; after the step their state contains the velocity of the next one.
///
/// For robots that PlantOptions::dynamics moves, the plant applies commands, delays, disturbances
/// and presence. The dynamics integrate their motion.
class Plant {
 public:
  /// @param x0  states of all bodies, in team order (nx)
  /// @throws std::invalid_argument naming an invalid start or disturbance
  Plant(Team team, std::vector<double> x0, const PlantOptions& options = {});

  /// Advances by dt [s] under the inputs u (nu). Allocates nothing.
  /// @return false if a state is no longer finite, or if no step was made: for u of another size,
  /// or dt not in (0, 1e6] s
  bool step(std::span<const double> u, double dt) noexcept;

  /// Absent bodies rest where they are and disturb no other. Initially all are present. A robot
  /// that joins starts again in its initial state. A target or obstacle starts at its initial
  /// position, with its current velocity.
  void set_presence(std::span<const Presence> presence) noexcept;

  /// Applies changes by events: moves of bodies, another wind. Allocates nothing.
  void surround(const Surroundings& around) noexcept;

  const Team& team() const { return team_; }
  std::span<const double> x() const noexcept { return std::span(z_).first(nx_); }
  /// States as x(), with the entries that robots measure themselves replaced by those measurements.
  std::span<const double> sensed() noexcept;
  double time() const noexcept { return time_; }

 private:
  struct Part {
    Model model;
    std::size_t x, u;  // offsets
    int robot;         // index among the robots, or -1
    bool there = true;
    bool moved = false;           // by PlantOptions::dynamics
    std::vector<int> slipping{};  // states whose rate wheel slip reduces
  };
  struct YawLag {
    std::size_t input, state;
  };
  /// Consecutive bodies that one thread integrates together: first index and count of parts, states
  /// and lags.
  struct Bunch {
    std::size_t part, parts, x, nx, lag, lags;
  };
  static constexpr std::size_t scratch_rows =
      1 + RungeKuttaScratch::rows_needed;  // the states, and the scratch of a Runge-Kutta step

  void set_accelerations() noexcept;
  void set_wind() noexcept;
  void move_by_dynamics(double t) noexcept;
  void integrate(std::span<const double> u, double from, double s) noexcept;
  void integrate(const Bunch& bunch, std::span<const double> u, double s) noexcept;
  void divide();

  Team team_;
  Disturbances disturbances_;
  std::size_t nx_;
  std::vector<Part> parts_;
  std::vector<YawLag> lags_;
  std::vector<Bunch> bunches_;
  std::vector<double> z_;  // states of all bodies, then the lagging yaw inputs
  // Longest integration step, as a fraction of the time constant of the fastest robot model.
  static constexpr double part_of_fastest = 0.5;
  double longest_ = std::numeric_limits<double>::infinity();  // integration step [s]
  std::vector<double> start_, sensed_;
  std::vector<double> u_, scratch_;
  InputDelay delay_;
  std::optional<Gusts> gusts_;
  std::optional<Wakes> wakes_;
  Motions motions_;
  RobotDynamics* dynamics_;
  std::shared_ptr<ThreadPool> pool_;
  double steered_for_;                          // step that the velocities of motions_ are set for [s]
  std::vector<Vec3<double>> p_, acceleration_;  // of the robots
  bool pushed_;
  Surroundings::Wind wind_{};   // set by an event
  Vec3<double> wind_before_{};  // before that event [m/s^2]
  bool wind_moves_ = false;
  double time_ = 0.0;
};

}  // namespace sightline
