/// Simulated IMU of a vehicle.
#pragma once

#include <cstdint>

#include "bridges/dds/links/inertial_samples.hpp"
#include "bridges/dds/topics/conversion.hpp"
#include "sightline/vehicle.hpp"
#include "sightline/world.hpp"

namespace sightline::dds {

/// Exact means over dt [s] in which a body moves from one motion to another, both in G. The gyro
/// means integrate to the rotation, those of the force with gravity to the change of velocity.
InertialSample inertial_between(const Motion& before, const Motion& after, double dt) noexcept;

/// Errors of an IMU: white noise, and biases that begin at random and walk.
class SimulatedImu {
 public:
  /// @throws std::invalid_argument naming a number of `imu` that is out of its range
  SimulatedImu(const Imu& imu, std::uint64_t seed);

  /// The measurement of exact means over dt [s].
  InertialSample measure(InertialSample exact, double dt) noexcept;

 private:
  Imu imu_;
  RandomStream gyro_noise_, gyro_walk_, force_noise_, force_walk_;
  Vec3<double> gyro_bias_, force_bias_;
};

}  // namespace sightline::dds
