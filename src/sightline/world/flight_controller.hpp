/// The flight controller of a vehicle: what an autopilot makes of commands, 500 times a second.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "sightline/model/model.hpp"
#include "sightline/world/mixer.hpp"
#include "sightline/world/rigid_body.hpp"

namespace sightline {

/// What a robot's inputs command.
enum class Commands {
  tilt,        ///< u_f, u_s, u_z, u_psi of (24): parts of the vehicle's tilt_max, climb_max and yaw_max
  velocity,    ///< forward, to the left and up [m/s], yaw rate [rad/s], in the heading frame V
  full_state,  ///< acceleration in G [m/s^2], with the velocity and position that it leads to; heading along x
};

/// Those of a robot that a vehicle can be: multirotor, angle_multirotor, hover_multirotor, velocity_multirotor, point_mass; none of
/// any other.
std::optional<Commands> commands_of(const Model& robot);
/// The robots that a vehicle can be, in words; of those with such commands alone.
std::string robots_with_vehicles(std::span<const Commands> of = {});

/// A cascade as PX4's: velocity, attitude, rates, mixer.
///
///   acceleration   tilt commands: g tan(tilt_max u) forward and sideward; velocity commands: PID on the velocity; full state: the same
///                  on the commanded trajectory's velocity and position_gain times the way to it, plus its acceleration
///   attitude       thrust along (a_x, a_y, g); the tilt error asks for rates, the heading for none but the yaw rate
///   rates          torque I gain (error), and w x I w
///   collective     PI on the climb, over the cosine of the tilt
///
/// Under tilt commands the tilt does not depend on the climb, as in (24). The trajectory of full-state commands begins at the body and stays
/// within 0.5 m and 1 m/s of it, so that it waits for a body that cannot follow.
class FlightController {
 public:
  static constexpr double period = 0.002;  // [s]

  FlightController(const Vehicle& vehicle, Commands commands);

  /// Forgets what it has integrated.
  void begin() noexcept;
  /// What the rotors are to lift, every `period`.
  /// @param body  as the vehicle knows it
  /// @param R     of body.q
  Thrusts update(const RigidBody& body, const Rotation& R, const std::array<double, 4>& u) noexcept;

 private:
  void lead(const RigidBody& body, const Vec3<double>& a) noexcept;
  Vec3<double> velocity_acceleration(const RigidBody& body, const Vec3<double>& wanted,
                                     const Vec3<double>& ahead) noexcept;

  Vehicle vehicle_;
  Commands commands_;
  Mixer mixer_;
  double climb_integral_ = 0.0;
  Vec2<double> velocity_integral_{}, acceleration_{}, v_before_{};
  Vec3<double> lead_p_{}, lead_v_{};  // the trajectory of full-state commands, in G
  bool first_ = true;
};

}  // namespace sightline
