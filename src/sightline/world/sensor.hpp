/// Measurement of the simulated world: the true state with delay, noise, drift and injected faults.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sightline/ocp/surroundings.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/fault.hpp"

namespace sightline {

struct SensorOptions {
  std::uint64_t seed = 1;
  Noise noise{};
  Odometry odometry{};   ///< of robots
  double delay = 0.0;    ///< from state to measurement [s], in [0, 1]; rounded up to whole measurements
  double period = 0.01;  ///< shortest time between two measurements [s]; sizes the buffer of past states
  std::vector<BodyId> velocity_unknown{};  ///< bodies whose measured velocity is 0
  std::vector<Fault> faults{};
};

/// Measures all bodies at once, as motion capture does. `StateRoles` identify the states of the
/// robot's pose and velocity. Noise and jumps are added to positions, noise also to velocities.
/// Heading noise rotates headings, which stay normalised. A robot whose pose is not among its
/// states gets no noise. The odometry errors are added likewise, with their values at the time of
/// the measurement.
///
/// Each measurement has a stamp for each body: the time of the measured state. Without noise, delay
/// and faults the measurement equals the state, bit for bit. Each fault draws from its own random
/// stream.
class Sensor {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  explicit Sensor(const Team& team, const SensorOptions& options = {});

  /// Takes the true states x (nx) at t [s], which must increase, and returns the measured states
  /// (nx). They are valid until the next call. Until the first state is `delay` old, the first
  /// state is measured. Allocates nothing.
  std::span<const double> measure(double t, std::span<const double> x) noexcept;
  /// A body starts again in this state of the world: its earlier measurements are discarded.
  void begin(BodyId body, std::span<const double> x) noexcept;
  /// Sets the faults that events add. Allocates nothing.
  void surround(const Surroundings& around) noexcept;
  /// Stamps of the last measurement of each body [s]; minus infinity before the first one arrives.
  std::span<const double> stamps() const noexcept { return stamps_; }

 private:
  struct Part {
    Model model;
    std::size_t x;
    RandomStream position, heading, velocity;
    // Indices in the stacked state.
    std::vector<std::pair<std::size_t, std::size_t>> positions;  // axis of G, index
    std::optional<std::array<std::size_t, 2>> direction{};
    std::optional<std::size_t> angle{};
    std::vector<std::size_t> velocities;
    std::optional<OdometryErrors> odometry{};  ///< of a robot with odometry errors
  };
  /// A fault of one body.
  struct Injection {
    Fault fault;
    std::size_t part;
    RandomStream chance;
  };
  /// Combined effect of all faults on one measurement.
  struct FaultEffect {
    double delay = 0.0;
    bool lost = false, frozen = false;
  };

  void remember(double t, std::span<const double> x) noexcept;
  std::size_t youngest(double until) const noexcept;
  void add_noise(Part& part) noexcept;
  void turn(const Part& part, double angle) noexcept;
  void add_drift(Part& part, double since) noexcept;
  void spoil(std::size_t part, double t, FaultEffect& effect) noexcept;
  /// Applies one fault to the measurement of a body.
  /// @param hit    whether a fault with a probability occurs this time
  /// @param which  for FaultKind::nan, selects the number, in [0, 1]
  void befall(const Fault& fault, const Part& part, bool hit, double which, FaultEffect& effect) noexcept;

  Noise noise_;
  double delay_;
  std::vector<Part> parts_;
  std::vector<std::size_t> unknown_;  // indices in the stacked state of velocities that are not measured
  std::vector<Injection> injections_;
  std::vector<Fault> brought_;                 // faults from events
  std::vector<double> times_, past_;           // ring buffer of states, the oldest at oldest_
  std::vector<double> fresh_, seen_, stamps_;  // measured now; as received; stamps of seen_
  std::size_t oldest_ = 0, count_ = 0;
};

}  // namespace sightline
