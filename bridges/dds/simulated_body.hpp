/// How a vehicle that is stood in for moves: a point that follows velocities with a lag, or a rigid body with rotors.
#pragma once

#include <memory>
#include <optional>

#include "bridges/dds/conversion.hpp"
#include "sightline/world/rotorcraft.hpp"

namespace sightline::dds {

/// How fast an autopilot climbs to where its take-off ends, and sinks to the ground where it lands, as PX4 does by default [m/s].
double takeoff_speed(double height, double altitude) noexcept;
double landing_speed(double height) noexcept;

/// In G, over the ground z = 0, by steps of VehicleSimulator::period.
class SimulatedBody {
 public:
  /// On the ground.
  /// @param rotors  none: the point, whose velocity lags by 0.3 s
  SimulatedBody(const Vec3<double>& p, double heading, const std::optional<Vehicle>& rotors,
                Commands commands = Commands::velocity);

  /// With motors off: it stands, or falls.
  void rest() noexcept;
  /// Under Commands::velocity.
  /// @param v  [m/s], in G
  /// @param a  fed forward [m/s^2]
  /// @param r  rate of the heading [rad/s]
  void follow(const Vec3<double>& v, const Vec3<double>& a, double r) noexcept;
  /// Under Commands::tilt, with rotors.
  /// @param u  of (24)
  void tilt(const std::array<double, 4>& u) noexcept;

  const Motion& motion() const { return motion_; }
  bool on_ground() const { return motion_.p.z < ground; }

 private:
  static constexpr double ground = 0.02;  // [m]

  void fly(const std::array<double, 4>& u) noexcept;

  std::unique_ptr<Rotorcraft> rotorcraft_;
  Motion motion_;
};

}  // namespace sightline::dds
