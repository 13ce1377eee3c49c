/// Motion model of a simulated vehicle: a point mass with velocity lag, or a rigid body with
/// rotors.
#pragma once

#include <memory>
#include <optional>

#include "bridges/dds/topics/conversion.hpp"
#include "sightline/world/rotorcraft.hpp"

namespace sightline::dds {

/// Vertical speeds of an autopilot [m/s]: climb to the take-off altitude, and descent to land
/// (negative), as PX4's defaults.
double takeoff_speed(double height, double altitude) noexcept;
double landing_speed(double height) noexcept;

/// Motion in G above the ground z = 0, in steps of VehicleSimulator::period.
class SimulatedBody {
 public:
  /// Starts on the ground.
  /// @param rotors  none: the point mass, whose velocity lags by 0.3 s
  SimulatedBody(const Vec3<double>& p, double heading, const std::optional<Vehicle>& rotors,
                Commands commands = Commands::velocity);

  /// One step with motors off: stands or falls.
  void rest() noexcept;
  /// One step under Commands::velocity.
  /// @param v  [m/s], in G
  /// @param a  feed-forward acceleration [m/s^2]
  /// @param r  heading rate [rad/s]
  void follow(const Vec3<double>& v, const Vec3<double>& a, double r) noexcept;
  /// One step under Commands::tilt, with rotors.
  /// @param u  of (24)
  void tilt(const std::array<double, 4>& u) noexcept;

  const Motion& motion() const { return motion_; }
  bool on_ground() const { return motion_.p.z < ground; }

 private:
  static constexpr double ground = 0.02;  // height below which it counts as on the ground [m]

  void fly(const std::array<double, 4>& u) noexcept;

  std::unique_ptr<Rotorcraft> rotorcraft_;
  Motion motion_;
};

}  // namespace sightline::dds
