/// The measurement of the world: the true state with delay, noise, drift and injected faults.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sightline/ocp/event/surroundings.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/fault.hpp"

namespace sightline {

struct SensorOptions {
  std::uint64_t seed = 1;
  Noise noise{};
  Odometry odometry{};   ///< of robots
  double delay = 0.0;    ///< from state to measurement [s], in [0, 1]; rounded up to whole measurements
  double period = 0.01;  ///< shortest time between two measurements [s]; sizes the memory of past states
  std::vector<BodyId> velocity_unknown{};  ///< these are seen at rest
  std::vector<Fault> faults{};
};

/// Measures all bodies at once, as motion capture does. What a state is, the robot's pose and velocity tell
/// (`StateRoles`): noise and jumps are added to positions, turn headings, which stay on the circle, and are added to
/// velocities. A robot whose pose is no state gets none. The odometry's errors are added likewise, at the time of the measurement.
///
/// Each measurement has a time for each body: that of the state that was seen. Without noise, delay and faults the
/// measurement is the state, bit for bit. Faults draw from streams of their own.
class Sensor {
 public:
  /// @throws std::invalid_argument for an option out of its range, named
  explicit Sensor(const Team& team, const SensorOptions& options = {});

  /// Takes the true states at t [s], which must rise, and gives what is seen then (nx), valid until the next
  /// call. Until the first state is `delay` old, that state is seen. Allocates nothing.
  std::span<const double> measure(double t, std::span<const double> x) noexcept;
  /// A body begins anew in this state of the world: what was seen of it before is not of it.
  void begin(BodyId body, std::span<const double> x) noexcept;
  /// The faults that events bring. Allocates nothing.
  void surround(const Surroundings& around) noexcept;
  /// Times of the last measurement of each body [s]; minus infinity before the first that arrived.
  std::span<const double> stamps() const noexcept { return stamps_; }

 private:
  struct Part {
    Model model;
    std::size_t x;
    RandomStream position, heading, velocity;
    // In the stacked state.
    std::vector<std::pair<std::size_t, std::size_t>> positions;  // axis of G, place
    std::optional<std::array<std::size_t, 2>> direction{};
    std::optional<std::size_t> angle{};
    std::vector<std::size_t> velocities;
    std::optional<OdometryErrors> odometry{};  ///< of a robot, where it has any
  };
  /// A fault of one body.
  struct Injection {
    Fault fault;
    std::size_t part;
    RandomStream chance;
  };
  /// What faults make of a measurement.
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
  /// @param which  of its numbers, in [0, 1]; of a fault that makes one of them none
  void befall(const Fault& fault, const Part& part, bool hit, double which, FaultEffect& effect) noexcept;

  Noise noise_;
  double delay_;
  std::vector<Part> parts_;
  std::vector<std::size_t> unknown_;  // velocities in the stacked state
  std::vector<Injection> injections_;
  std::vector<Fault> brought_;                 // by events
  std::vector<double> times_, past_;           // ring of states, the oldest at oldest_
  std::vector<double> fresh_, seen_, stamps_;  // as measured now; as it arrived
  std::size_t oldest_ = 0, count_ = 0;
};

}  // namespace sightline
