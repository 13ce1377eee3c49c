/// One vehicle in flight: rigid body, rotors, air, ground and flight controller.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "sightline/vehicle.hpp"
#include "sightline/world.hpp"
#include "sightline/world/flight_controller.hpp"
#include "sightline/world/mixer.hpp"

namespace sightline {

inline constexpr double rotorcraft_step = 0.001;  // [s]
/// A ground contact at a higher speed is a crash [m/s].
inline constexpr double landing_speed_max = 0.5;

/// Force and torque on a rigid body.
struct Wrench {
  Vec3<double> force{};   ///< on the centre of mass, in G [N]
  Vec3<double> torque{};  ///< about the centre of mass, in B [N m]
};

/// A vehicle that advances in steps of 1 ms; its flight controller acts at every second one. The
/// rotor speeds follow their commands with first-order lags, discretised exactly for held commands,
///
///   s += (1 - e^{-h / tau}) (sqrt(f / k_f) - s),   tau = tau_up where s rises, else tau_down
///
/// The ground is the plane z = 0 of G; a vehicle stands there with p_z = 0. After contact the
/// ground holds the vehicle upright and at rest until the thrust lifts it.
class Rotorcraft {
 public:
  /// @param seed, body  of the random streams of its IMU
  /// @throws std::invalid_argument from Vehicle::check()
  Rotorcraft(const Vehicle& vehicle, Commands commands, std::uint64_t seed = 1, int body = 0);

  /// Starts upright, with the rotors at hover speed.
  /// @param d  heading
  /// @param v  velocity in G
  void begin(const Vec3<double>& p, const Vec2<double>& d, const Vec3<double>& v, double yaw_rate) noexcept;
  /// Advances by rotorcraft_step.
  /// @param u    the robot's inputs, as Commands defines them
  /// @param air  velocity of the air in G [m/s]
  void step(const std::array<double, 4>& u, const Vec3<double>& air) noexcept;

  /// First half of a step, for another simulator that moves the body. Returns the force and torque
  /// of rotors and air over rotorcraft_step.
  Wrench push(const std::array<double, 4>& u, const Vec3<double>& air) noexcept;
  /// Second half of the step: sets the new state of the body.
  void moved_to(const Vec3<double>& p, const Quaternion& q, const Vec3<double>& v,
                const Vec3<double>& w) noexcept {
    body_.p = p, body_.q = q, body_.v = v, body_.w = w;
  }

  const Vehicle& vehicle() const { return vehicle_; }
  const RigidBody& body() const { return body_; }
  /// The body as the flight controller estimates it: the true state plus the errors of an IMU, if
  /// any.
  RigidBody seen() const noexcept { return inertial_ ? inertial_->seen(body_) : body_; }
  Rotation attitude() const { return rotation(body_.q); }
  Vec2<double> heading() const { return sightline::heading(attitude()); }
  double heading_rate() const { return sightline::heading_rate(attitude(), body_.w); }  ///< [rad/s]
  double thrust() const;  ///< of all rotors [N], with a full battery
  double lift() const;    ///< the same at the present battery charge [N]
  /// Highest speed of a ground contact above landing_speed_max [m/s]; 0 if none.
  double crash_speed() const { return crash_speed_; }

 private:
  void control(const Rotation& R, const std::array<double, 4>& u) noexcept;
  double k_f() const noexcept;
  void spin_up(const Thrusts& wanted) noexcept;
  void meet_ground() noexcept;

  Vehicle vehicle_;
  FlightController controller_;
  std::optional<InertialErrors> inertial_;
  RigidBody body_;
  std::size_t rotors_;
  double rise_, fall_;  // gain of the lag in one step
  Thrusts wanted_{};
  std::array<double, rotors_max> speed_{};  // [rad/s]
  std::int64_t ticks_ = 0;
  double crash_speed_ = 0.0;
};

}  // namespace sightline
