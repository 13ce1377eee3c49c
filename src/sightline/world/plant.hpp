/// The simulated world: the continuous models of all bodies, with what disturbs them.
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

/// Moves robots of a plant in place of their models: rigid bodies with rotors, another simulation. Nothing here
/// allocates, locks or throws.
///
/// A step: steer() for each robot that is there, move() once for all of them, show() for each.
class RobotDynamics {
 public:
  virtual ~RobotDynamics() = default;
  /// Whether it moves that robot; the same at any time.
  virtual bool moves(BodyId robot) const noexcept = 0;
  /// From t [s] on the robot is in the state x of its model: at first, and whenever it joins again.
  virtual void begin(BodyId robot, double t, const double* x) noexcept = 0;
  /// The robot's inputs u, and the acceleration of G [m/s^2] that wind, gusts and wakes give its model, held over the next move().
  virtual void steer(BodyId robot, const double* u, const Vec3<double>& acceleration) noexcept = 0;
  /// Moves the robots that were steered on to t [s]; the others rest.
  virtual void move(double t) noexcept = 0;
  /// Writes the state x of the robot's model.
  virtual void show(BodyId robot, double* x) const noexcept = 0;
  /// Puts what the robot measures of itself, with its errors, in place of those numbers of its true state x.
  virtual void sense(BodyId /*robot*/, double* /*x*/) const noexcept {}
};

struct PlantOptions {
  std::uint64_t seed = 1;
  Disturbances disturbances{};
  double period = 0.01;  ///< shortest step that will be asked for [s]; sizes the queue of delayed commands
  std::vector<BodyMotion> motions{};  ///< of targets and obstacles; the others keep their velocity
  /// Of targets and obstacles that events move, in the order of the team [m/s]; 0, or none: any.
  std::vector<double> speed_max{};
  RobotDynamics* dynamics = nullptr;  ///< of the robots that it moves; outlives the plant
  DownwashOptions downwash{};         ///< of vehicles; for the dynamics
  /// Threads that at least so many bodies, or vehicles, are shared over; none: that of the caller alone. The result is the same.
  std::shared_ptr<ThreadPool> pool{};
  static constexpr int shared_from = 256, vehicles_shared_from = 16;
};

/// x' = f(x, u) of each body by the classical Runge-Kutta step with u held (zero-order hold). After each step
/// every heading is put back on the circle. Undisturbed, a step is one Runge-Kutta step of each model, bit
/// for bit.
///
/// Wind, gusts and wakes are accelerations of the robots, held over a step; a delayed command that comes into
/// force within a step divides it there. Targets and obstacles with a motion hold its velocity over a step, and
/// show at once the velocity of the next one.
///
/// Robots that PlantOptions::dynamics moves have commands, delays, disturbances and presence of the plant, and the motion of
/// those dynamics.
class Plant {
 public:
  /// @param x0  states of all bodies, in the order of the team (nx)
  /// @throws std::invalid_argument for a start or a disturbance that cannot be, named
  Plant(Team team, std::vector<double> x0, const PlantOptions& options = {});

  /// Advances by dt [s] under the inputs u (nu). Allocates nothing.
  /// @return false where a state is no longer finite, or where there was no step: for inputs of another number, and dt
  /// not in (0, 1e6]
  bool step(std::span<const double> u, double dt) noexcept;

  /// Bodies that are absent rest where they are, and disturb nobody; all are there at first. A robot that comes is
  /// where and as it was at the start; a target or an obstacle is there too, with the velocity it has by now.
  void set_presence(std::span<const Presence> presence) noexcept;

  /// What events changed: bodies that go to a place, another wind. Allocates nothing.
  void surround(const Surroundings& around) noexcept;

  const Team& team() const { return team_; }
  std::span<const double> x() const noexcept { return std::span(z_).first(nx_); }
  /// The same, with what robots measure of themselves as they do.
  std::span<const double> sensed() noexcept;
  double time() const noexcept { return time_; }

 private:
  struct Part {
    Model model;
    std::size_t x, u;  // offsets
    int robot;         // index among the robots, or -1
    bool there = true;
    bool moved = false;           // by other dynamics than its model's
    std::vector<int> slipping{};  // states that change less where wheels slip
  };
  struct YawLag {
    std::size_t input, state;
  };
  /// Bodies that are integrated at once, by one thread: which parts, states and lags, from first to last.
  struct Bunch {
    std::size_t part, parts, x, nx, lag, lags;
  };
  static constexpr std::size_t scratch_rows =
      1 + RungeKuttaScratch::rows_needed;  // its numbers, and those of a step

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
  // A step of the integration is at most that part of the time constant of the fastest motion of a robot.
  static constexpr double part_of_fastest = 0.5;
  double longest_ = std::numeric_limits<double>::infinity();  // step [s]
  std::vector<double> start_, sensed_;
  std::vector<double> u_, scratch_;
  InputDelay delay_;
  std::optional<Gusts> gusts_;
  std::optional<Wakes> wakes_;
  Motions motions_;
  RobotDynamics* dynamics_;
  std::shared_ptr<ThreadPool> pool_;
  double steered_for_;                          // step that the bodies' velocities are for [s]
  std::vector<Vec3<double>> p_, acceleration_;  // of the robots
  bool pushed_;
  Surroundings::Wind wind_{};   // that comes up
  Vec3<double> wind_before_{};  // it [m/s^2]
  bool wind_moves_ = false;
  double time_ = 0.0;
};

}  // namespace sightline
