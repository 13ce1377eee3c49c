/// Realistic multirotors: parameters, rotors, mixer, flight controller, inertial sensors, air.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/team.hpp"
#include "sightline/world.hpp"

namespace sightline {

// Downwash: the air that a vehicle accelerates downward onto vehicles below it.

/// Downwash parameters of a vehicle world.
struct DownwashOptions {
  static constexpr std::string_view name = "world";

  double scale = 0.0;

  static constexpr auto parameters() {
    return Parameters{parameter("downwash", &DownwashOptions::scale, "", Bounds{0.0, 2.0, "0 to 2"},
                                "speed of the air under vehicles, over that of momentum theory; 0: still")};
  }

  /// @throws std::invalid_argument naming the parameter, its value and its range
  void check() const { check_parameters(*this); }
};

/// Mean flow below the rotors of one vehicle, modelled as one disc of radius R. It is that of
/// momentum theory at the disc and a turbulent round jet far below. At depth z along the jet and
/// distance r off its axis,
///
///   w = sqrt(2 F / (pi rho)) / b  e^{-r^2 / b^2},
///   F = T / 2 (1 + zeta),   b^2 = 2 R^2 / (1 + zeta) + (growth z)^2,   zeta = z / sqrt(R^2 + z^2)
///
/// F is the momentum flux, rho times the integral of w^2 over a cross section at any z. F is T / 2
/// at the disc, where pressure carries the other half, and T far below. The speed on the axis is
/// v_i = sqrt(T / (2 rho pi R^2)) at the disc and approaches 2 v_i. Where the jet has grown, it
/// decays as 1 / z. Above the disc the air is at rest.
///
/// The air at depth z left the disc z / w(0, z) ago and stays below the place of the disc at that
/// time, at constant velocity v of the disc: p - z / w(0, z) v. The speed follows the thrust without
/// delay. Wind and ground do not bend the jet. Sources: docs/vehicles.md.
struct Jet {
  static constexpr double air_density = 1.225;  ///< rho [kg/m^3]
  static constexpr double growth = 0.113;       ///< of the radius b at which the speed is 1/e, over z

  Vec3<double> p{};             ///< centre of the disc, in G [m]
  Vec3<double> down{0, 0, -1};  ///< opposite to the thrust, |down| = 1
  double thrust = 0.0;          ///< T [N], >= 0
  double radius2 = 1.0;         ///< R^2 [m^2], > 0
  Vec3<double> v{};             ///< velocity of the disc, in G [m/s]

  /// Velocity in G of the jet's air at the point `there` [m/s]; 0 if a number is not finite.
  Vec3<double> air(const Vec3<double>& there) const noexcept;
};

// The inertial measurement unit of a vehicle, and the estimation errors that it causes.

/// Errors of gyroscope and accelerometer, equal for each axis:
///
///   measured - true = b(t) + white noise,   b(t) = b_0 + random walk
///
/// b_0 is drawn once per flight, with the standard deviation `..._bias`. White noise of density N
/// has the standard deviation N / sqrt(h) over a step h. A walk of density K has the standard
/// deviation K sqrt(t) after t.
///
/// The defaults are those of bmi088.
struct Imu {
  static constexpr std::string_view name = "imu";

  double gyro_noise = 2.4e-4;
  double gyro_bias = 1.7e-3;
  double gyro_walk = 3.9e-5;
  double accelerometer_noise = 1.9e-3;
  double accelerometer_bias = 0.05;
  double accelerometer_walk = 6e-3;

  static constexpr auto parameters() {
    using I = Imu;
    return Parameters{parameter("gyro_noise", &I::gyro_noise, "rad/s/sqrt(Hz)", from_zero,
                                "density of the white noise of the rates"),
                      parameter("gyro_bias", &I::gyro_bias, "rad/s", from_zero,
                                "their bias at the start, standard deviation"),
                      parameter("gyro_walk", &I::gyro_walk, "rad/s/sqrt(s)", from_zero,
                                "density of the random walk of that bias"),
                      parameter("accelerometer_noise", &I::accelerometer_noise, "m/s^2/sqrt(Hz)", from_zero,
                                "density of the white noise of the specific force"),
                      parameter("accelerometer_bias", &I::accelerometer_bias, "m/s^2", from_zero,
                                "its bias at the start, standard deviation"),
                      parameter("accelerometer_walk", &I::accelerometer_walk, "m/s^2/sqrt(s)", from_zero,
                                "density of the random walk of that bias")};
  }

  static Imu bmi088() { return {}; }
  static Imu icm20689();
  static std::array<Preset<Imu>, 2> presets();

  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this, "vehicle.imu"); }
};

/// Errors of an autopilot's estimator, a complementary filter, caused by its IMU. With attitude
/// error phi (R_estimated = exp([phi]) R, in G), gyroscope error w~ and accelerometer error a~, e_z
/// up,
///
///   y      = phi + e_z x R a~ / g         measurement of phi by the accelerometer, v known
///   phi'   = R (w~ - w_b) - attitude_gain y
///   w_b'   = bias_gain R^T y              estimated gyroscope bias, from 0
///   v_err' = g phi x e_z + R a~ - velocity_gain v_err
///
/// (Mahony, Hamel and Pflimlin 2008, to first order in the errors, for a specific force of about g
/// e_z). Position, velocity and compass bound v_err and the heading error. Their measurements are
/// taken as exact, because the vehicle's motion causes no error in them.
class InertialErrors {
 public:
  static constexpr double attitude_gain = 0.5;  ///< [1/s]
  static constexpr double bias_gain = 0.05;     ///< [1/s^2]
  static constexpr double velocity_gain = 2.0;  ///< [1/s]

  /// Each of the four error sources has its own random stream.
  /// @throws std::invalid_argument from Imu::check()
  InertialErrors(const Imu& imu, std::uint64_t seed, int body);

  /// Restarts the estimator in steady state at this attitude; the biases continue.
  void begin(const Rotation& R) noexcept;
  /// One step of h [s] at this attitude.
  void advance(const Rotation& R, double h) noexcept;

  /// The body as the flight controller estimates it: attitude, angular velocity and velocity have
  /// errors.
  RigidBody seen(const RigidBody& body) const noexcept;

  const Vec3<double>& attitude() const noexcept { return phi_; }  ///< phi, in G [rad]
  const Vec3<double>& rate() const noexcept { return rate_; }     ///< w~ - w_b of the last step, in B [rad/s]
  const Vec3<double>& velocity() const noexcept { return v_; }    ///< v_err, in G [m/s]
  const Vec3<double>& gyro_bias() const noexcept { return gyro_bias_; }  ///< b, in B [rad/s]
  const Vec3<double>& accelerometer_bias() const noexcept { return accelerometer_bias_; }  ///< in B [m/s^2]

 private:
  Imu imu_;
  RandomStream gyro_noise_, gyro_walk_, accelerometer_noise_, accelerometer_walk_;
  Vec3<double> gyro_bias_, accelerometer_bias_;
  Vec3<double> phi_{}, rate_{}, estimated_bias_{}, v_{};
};

// Parameters of a multirotor: body, rotors, air and flight controller. Sources: docs/vehicles.md.

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
    return Parameters{
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
        parameter("attitude_gain", &V::attitude_gain, "1/s", gain, "commanded rate over tilt error"),
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
  /// R^2 of one disc with the area of all rotors [m^2].
  double disc_radius2() const { return static_cast<double>(rotors()) * square(rotor_radius); }
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
std::string describe(const RobotVehicle& vehicle);

}  // namespace sightline
