/// Parameters of a multirotor: body, rotors, air and flight controller. Sources: docs/vehicles.md.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/fixed.hpp"
#include "sightline/base/parameter.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/world/imu.hpp"

namespace sightline {

inline constexpr std::size_t rotors_min = 4, rotors_max = 8;

/// A multirotor with equal rotors in the plane of its centre of mass. Their thrust is along z of
/// the body B (x forward, y left, z up).
///
///   thrust of a rotor at speed s [rad/s]   f = k_f s^2 (1 - battery_sag min(1, t / battery_time))
///                                          0 <= s <= speed_max
///   its torque about z of the body         -spin k_m f
///   drag of the air, in B                  -(drag + rotor_drag (sum of s) (1, 1, 0)) (v - air)
///
/// The defaults are x500().
struct Vehicle {
  static constexpr std::string_view name = "vehicle";

  double mass = 2.06;
  Vec3<double> inertia = {0.0217, 0.0217, 0.040};
  std::vector<double> rotor_x = {0.174, -0.174, 0.174, -0.174};
  std::vector<double> rotor_y = {-0.174, 0.174, 0.174, -0.174};
  std::vector<double> spin = {1, 1, -1, -1};
  double rotor_radius = 0.127;
  double k_f = 8.54858e-6;
  double k_m = 0.016;
  double speed_max = 1000.0;
  double tau_up = 0.0125;
  double tau_down = 0.025;
  double battery_sag = 0.0;
  double battery_time = 600.0;
  double rotor_drag = 8.06428e-5;
  Vec3<double> drag = {0.0, 0.0, 0.25};
  double radius = 0.373;
  double height = 0.24;
  double attitude_gain = 6.5;
  double rate_gain = 20.0;
  double yaw_gain = 6.0;
  double position_gain = 0.95;
  double velocity_gain = 1.8;
  double velocity_integral = 0.4;
  double velocity_damping = 0.2;
  double climb_gain = 4.0;
  double climb_integral = 2.0;
  double tilt_max = 0.2;
  double climb_max = 1.0;
  double yaw_max = 1.6;
  double tilt_limit = 0.6;
  std::optional<Imu> imu{};  ///< none: the flight controller uses the true state

  static constexpr auto parameters() {
    using V = Vehicle;
    // Shorter lags would need a step shorter than rotorcraft_step.
    constexpr Bounds lag = {0.004, 1.0, "0.004 to 1"};
    // The upper bound suits control loops that are closed every 2 ms.
    constexpr Bounds gain = {1e-3, 100.0, "0.001 to 100"}, tilt = {1e-3, 1.2, "0.001 to 1.2"};
    constexpr Bounds part = {0.0, 0.9, "0 to 0.9"};
    return std::tuple{
        parameter("mass", &V::mass, "kg", above_zero, "with all that it carries"),
        parameter("inertia", &V::inertia, "kg m^2", above_zero, "about x, y, z of the body"),
        ListParameter<V, double>{"rotor_x", &V::rotor_x, "m", "of each rotor, forward of the centre", false,
                                 false},
        ListParameter<V, double>{"rotor_y", &V::rotor_y, "m", "of each rotor, to the left", false, false},
        ListParameter<V, double>{"spin", &V::spin, "",
                                 "of each rotor seen from above: 1 anticlockwise, -1 clockwise", false,
                                 false},
        parameter("rotor_radius", &V::rotor_radius, "m", above_zero, "of the disc of a rotor, for downwash"),
        parameter("k_f", &V::k_f, "N s^2", above_zero, "thrust of a rotor over its speed squared"),
        parameter("k_m", &V::k_m, "m", above_zero, "torque of a rotor over its thrust"),
        parameter("speed_max", &V::speed_max, "rad/s", above_zero, "greatest speed of a rotor"),
        parameter("tau_up", &V::tau_up, "s", lag, "lag of a rotor's speed when it rises"),
        parameter("tau_down", &V::tau_down, "s", lag, "lag of a rotor's speed when it falls"),
        parameter("battery_sag", &V::battery_sag, "", part,
                  "part of each rotor's thrust that an empty battery lacks"),
        parameter("battery_time", &V::battery_time, "s", above_zero,
                  "from a full battery, at the start, to an empty one"),
        parameter("rotor_drag", &V::rotor_drag, "N s^2/m", from_zero,
                  "drag of a rotor in its plane over its speed and that of the air"),
        parameter("drag", &V::drag, "N s/m", from_zero,
                  "drag of the body over the speed of the air, along x, y, z"),
        parameter("radius", &V::radius, "m", above_zero, "of the upright cylinder that touches others"),
        parameter("height", &V::height, "m", above_zero, "of that cylinder"),
        parameter("attitude_gain", &V::attitude_gain, "1/s", gain, "rate asked for over tilt error"),
        parameter("rate_gain", &V::rate_gain, "1/s", gain,
                  "angular acceleration over rate error, about x and y"),
        parameter("yaw_gain", &V::yaw_gain, "1/s", gain, "the same about z"),
        parameter("position_gain", &V::position_gain, "1/s", from_zero,
                  "velocity over position error, under full-state commands"),
        parameter("velocity_gain", &V::velocity_gain, "1/s", from_zero, "acceleration over velocity error"),
        parameter("velocity_integral", &V::velocity_integral, "1/s^2", from_zero, "and over its integral"),
        parameter("velocity_damping", &V::velocity_damping, "", from_zero, "and over the acceleration"),
        parameter("climb_gain", &V::climb_gain, "1/s", from_zero, "vertical acceleration over climb error"),
        parameter("climb_integral", &V::climb_integral, "1/s^2", from_zero, "and over its integral"),
        parameter("tilt_max", &V::tilt_max, "rad", tilt, "tilt at u_f = 1 or u_s = 1"),
        parameter("climb_max", &V::climb_max, "m/s", above_zero, "climb at u_z = 1"),
        parameter("yaw_max", &V::yaw_max, "rad/s", above_zero, "yaw rate at u_psi = 1"),
        parameter("tilt_limit", &V::tilt_limit, "rad", tilt, "greatest tilt under velocity commands")};
  }

  static Vehicle x500() { return {}; }
  static Vehicle crazyflie();
  static Vehicle ar_drone();
  static std::array<Preset<Vehicle>, 3> presets();

  std::size_t rotors() const { return rotor_x.size(); }
  double weight() const;       ///< [N]
  double thrust_max() const;   ///< of all rotors [N]
  double hover_speed() const;  ///< of a rotor [rad/s]
  /// Linear drag coefficient of the air in hover: horizontal, averaged over x and y, and vertical
  /// [N s/m].
  Vec3<double> hover_drag() const;
  /// Air velocity in G [m/s] whose drag gives the hovering vehicle this acceleration [m/s^2].
  /// Requires hover_drag() > 0 on each axis with a nonzero acceleration.
  Vec3<double> air(const Vec3<double>& acceleration) const;

  /// Sets attitude_gain and rate_gain for attitude poles of natural frequency omega [rad/s] and
  /// damping zeta. The rotors lag by tau [s].
  Vehicle& set_attitude(double omega, double zeta, double tau);

  /// @throws std::invalid_argument naming a number out of its range, rotors that leave an axis
  /// without torque, or insufficient thrust
  void check() const;
};

/// A file in the native format of a world that describes bodies.
struct ModelFile {
  std::string name;                ///< as in the scenario
  std::string text;                ///< content as read
  std::filesystem::path folder{};  ///< folder of the file; its relative references start there
};

/// A body in such a file.
struct ModelBody {
  ModelFile file;
  std::string body;  ///< its name in the file
};

/// A robot of a team that is a vehicle.
struct RobotVehicle {
  BodyId robot{};
  Vehicle vehicle{};
  std::string preset = "x500";       ///< start values of its parameters
  std::optional<ModelBody> model{};  ///< source of its mass, inertia and shape
};

/// Whether its flight controller measures through an IMU with errors.
inline bool has_imu(const RobotVehicle& vehicle) { return vehicle.vehicle.imu.has_value(); }

/// "x500, 2.06 kg, 4 rotors, thrust to weight 1.69"
std::string in_words(const RobotVehicle& vehicle);

}  // namespace sightline
