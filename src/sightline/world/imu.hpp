/// The inertial measurement unit of a vehicle, and the estimation errors that it causes.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "sightline/base/parameter.hpp"
#include "sightline/world/disturbance.hpp"
#include "sightline/world/rigid_body.hpp"

namespace sightline {

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
    return std::tuple{parameter("gyro_noise", &I::gyro_noise, "rad/s/sqrt(Hz)", from_zero,
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

}  // namespace sightline
