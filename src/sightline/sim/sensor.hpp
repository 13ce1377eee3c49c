/// What the controllers see of the world: the true state, late and with noise.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/ocp/team.hpp"
#include "sightline/sim/disturbance.hpp"

namespace sightline {

struct SensorOptions {
  std::uint64_t seed = 1;
  Noise noise{};
  double delay = 0.0;    ///< from state to measurement [s], in [0, 1]; rounded up to whole measurements
  double period = 0.01;  ///< shortest time between two measurements [s]; sizes the memory of past states
  std::vector<BodyId> velocity_unknown{};  ///< these are seen at rest
};

/// Measures all bodies at once, as motion capture does. What a state is, its name tells: p_* a position, d_x
/// with d_y a heading that is turned by the noise, psi an angle it is added to, v_* a velocity. Headings stay
/// on the circle.
///
/// Without noise and delay the measurement is the state, bit for bit.
class Sensor {
 public:
  /// @throws std::invalid_argument for an option out of its range, named
  explicit Sensor(const Team& team, const SensorOptions& options = {});

  /// Takes the true states at t [s], which must rise, and gives what is seen then (nx), valid until the next
  /// call. Until the first state is `delay` old, that state is seen. Allocates nothing.
  std::span<const double> measure(double t, std::span<const double> x) noexcept;

 private:
  struct Part {
    Model model;
    std::size_t x;
    RandomStream position, heading, velocity;
    std::vector<std::size_t> positions, headings, angles, velocities;  // in the stacked state
  };

  void remember(double t, std::span<const double> x) noexcept;
  void add_noise(Part& part) noexcept;

  Noise noise_;
  double delay_;
  std::vector<Part> parts_;
  std::vector<std::size_t> unknown_;         // velocities in the stacked state
  std::vector<double> times_, past_, seen_;  // ring of states, the oldest at oldest_
  std::size_t oldest_ = 0, count_ = 0;
};

}  // namespace sightline
