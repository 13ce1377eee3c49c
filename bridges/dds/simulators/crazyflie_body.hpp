/// Motion of a simulated Crazyflie under the firmware's Mellinger controller.
#pragma once

#include "bridges/dds/links/robot_state.hpp"
#include "bridges/dds/simulators/simulated_body.hpp"

namespace sightline::dds {

/// A body whose acceleration is that of the set-point plus the controller's gains over the mass,
/// times the errors of position and velocity. Steps of VehicleSimulator::period, in G.
class CrazyflieBody {
 public:
  /// Starts on the ground. The loops of `rotors` that the firmware replaces have no effect.
  CrazyflieBody(const Vec3<double>& p, double heading, Vehicle rotors);

  void rest() noexcept { body_.rest(); }
  void follow(const TrajectoryPoint& to) noexcept;
  /// Level, at this height [m]: horizontally it coasts.
  void level_out(double height) noexcept;

  const Motion& motion() const { return body_.motion(); }
  bool on_ground() const { return body_.on_ground(); }

 private:
  SimulatedBody body_;
};

}  // namespace sightline::dds
