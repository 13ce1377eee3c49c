/// The simulated world: the continuous models of all bodies, with what disturbs them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sightline/math/integrate.hpp"
#include "sightline/ocp/roster.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/motion.hpp"

namespace sightline {

struct PlantOptions {
  std::uint64_t seed = 1;
  Disturbances disturbances{};
  double period = 0.01;  ///< shortest step that will be asked for [s]; sizes the queue of delayed commands
  std::vector<BodyMotion> motions{};  ///< of targets and obstacles; the others keep their velocity
};

/// x' = f(x, u) of each body by the classical Runge-Kutta step with u held (zero-order hold). After each step
/// every heading is put back on the circle. Undisturbed, a step is one Runge-Kutta step of each model, bit
/// for bit.
///
/// Wind, gusts and wakes are accelerations of the robots, held over a step; a delayed command that comes into
/// force within a step divides it there. Targets and obstacles with a motion hold its velocity over a step, and
/// show at once the velocity of the next one.
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

  const Team& team() const { return team_; }
  std::span<const double> x() const noexcept { return std::span(z_).first(nx_); }
  double time() const noexcept { return time_; }

 private:
  struct Part {
    Model model;
    std::size_t x, u;  // offsets
    int robot;         // index among the robots, or -1
    bool there = true;
  };
  struct YawLag {
    std::size_t input, state;
  };

  void set_accelerations() noexcept;
  void integrate(std::span<const double> u, double s) noexcept;

  Team team_;
  Disturbances disturbances_;
  std::size_t nx_;
  std::vector<Part> parts_;
  std::vector<YawLag> lags_;
  std::vector<double> z_;  // states of all bodies, then the lagging yaw inputs
  std::vector<double> start_;
  std::vector<double> u_, scratch_;
  InputDelay delay_;
  std::optional<Gusts> gusts_;
  std::optional<Wakes> wakes_;
  Motions motions_;
  double steered_for_;                          // step that the bodies' velocities are for [s]
  std::vector<Vec3<double>> p_, acceleration_;  // of the robots
  bool pushed_;
  double time_ = 0.0;
};

}  // namespace sightline
