/// The flight controller of a vehicle: converts commands into rotor thrusts, 500 times a second.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "sightline/model.hpp"
#include "sightline/world.hpp"
#include "sightline/world/mixer.hpp"

namespace sightline {

/// Quantities that the inputs of a robot command.
enum class Commands {
  tilt,        ///< u_f, u_s, u_z, u_psi of (24): fractions of the vehicle's tilt_max, climb_max and yaw_max
  velocity,    ///< forward, left and up [m/s], yaw rate [rad/s], in the heading frame V
  full_state,  ///< acceleration in G [m/s^2], with the velocity and position that it integrates to; heading
               ///< along x
};

/// Command type of a robot model that a vehicle supports: multirotor, angle_multirotor,
/// hover_multirotor, velocity_multirotor, point_mass; none for any other.
std::optional<Commands> commands_of(const Model& robot);
/// Comma-separated names of the supported robot models, of all or only of these command types.
std::string robots_with_vehicles(std::span<const Commands> of = {});

/// Cascade in the structure of PX4's: velocity, attitude, rates, mixer.
///
///   acceleration   tilt commands: g tan(tilt_max u), forward and sideward
///                  velocity commands: PID on the velocity
///                  full state: the same PID on the velocity of the commanded trajectory plus
///                  position_gain times the position error, plus the commanded acceleration
///   attitude       thrust along (a_x, a_y, g), with the climb acceleration added to g except under
///                  tilt commands; the tilt error sets body rates, plus the commanded yaw rate
///   rates          torque I gain (error) + w x I w
///   collective     PI on the climb, divided by the cosine of the tilt
///
/// Under tilt commands the tilt does not depend on the climb, as in (24). The trajectory of
/// full-state commands starts at the body and stays within 0.5 m and 1 m/s of it. It therefore
/// waits for a body that cannot follow.
class FlightController {
 public:
  static constexpr double period = 0.002;  // [s]

  FlightController(const Vehicle& vehicle, Commands commands);

  /// Resets the integrators and filters.
  void begin() noexcept;
  /// Computes the rotor thrusts; called every `period`.
  /// @param body  as the vehicle estimates it
  /// @param R     attitude of body.q
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
  Vec3<double> lead_p_{}, lead_v_{};  // position and velocity of the full-state trajectory, in G
  bool first_ = true;
};

}  // namespace sightline
