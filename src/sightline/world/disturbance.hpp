/// Seeded disturbances of a flight: wind, gusts, wakes, command delay and lag, measurement noise
/// and drift.
///
/// Each source has its own random stream, from seed, kind and body. Enabling one disturbance leaves
/// the numbers of the others unchanged. The same seed and binary give the same numbers.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/base/fixed.hpp"
#include "sightline/base/parameter.hpp"

namespace sightline {

/// Wakes of hovering robots, section 7.2: each wake oscillates slowly and pushes the other robots,
/// more at short distance.
struct Airflow {
  double amplitude = 0.0;  ///< acceleration at `distance` [m/s^2], >= 0
  double distance =
      1.5;  ///< [m], > 0; at distance / q the push is q^2 times stronger, at most `strongest` times
  double frequency = 0.5;  ///< of the oscillation [Hz], >= 0

  static constexpr double strongest = 4.0;
  static constexpr double wander = 0.3;  ///< of the phase [rad/sqrt(s)]: coherent over about ten seconds
};

/// Standard deviations of the white noise of a measurement.
struct Noise {
  double position = 0.0;  ///< each axis [m], >= 0
  double heading = 0.0;   ///< [rad], >= 0
  double velocity = 0.0;  ///< each axis [m/s], >= 0
};

/// Errors of the robots' own odometry, besides the white noise. A measurement has the error
///
///   position, heading   b(t)                     b(t) = b_0 + random walk
///   velocity v          b(t) + scale v           for each velocity state
///
/// b_0 and scale are drawn once per flight, with the standard deviations `..._bias` and
/// `velocity_scale`. A walk of density K has the standard deviation K sqrt(t) after t. The errors
/// are independent: the position is not the integral of the measured velocity.
struct Odometry {
  static constexpr std::string_view name = "odometry";

  double position_bias = 0.0;
  double position_walk = 0.0;
  double heading_bias = 0.0;
  double heading_walk = 0.0;
  double velocity_bias = 0.0;
  double velocity_walk = 0.0;
  double velocity_scale = 0.0;

  static constexpr auto parameters() {
    using O = Odometry;
    return std::tuple{
        parameter("position_bias", &O::position_bias, "m", from_zero, "offset of each axis at the start"),
        parameter("position_walk", &O::position_walk, "m/sqrt(s)", from_zero,
                  "density of the random walk of that offset"),
        parameter("heading_bias", &O::heading_bias, "rad", from_zero, "offset of the heading at the start"),
        parameter("heading_walk", &O::heading_walk, "rad/sqrt(s)", from_zero,
                  "density of the random walk of that offset"),
        parameter("velocity_bias", &O::velocity_bias, "m/s", from_zero, "bias of each velocity at the start"),
        parameter("velocity_walk", &O::velocity_walk, "m/s/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("velocity_scale", &O::velocity_scale, "", from_zero,
                  "error of the scale of all velocities of a robot")};
  }

  bool operator==(const Odometry&) const = default;
};

/// All disturbances of a simulated flight. The default is none.
struct Disturbances {
  Vec3<double> wind{};             ///< steady acceleration in G [m/s^2]
  double gust_sigma = 0.0;         ///< of each horizontal and vertical axis [m/s^2], >= 0
  double gust_time = 1.0;          ///< correlation time of the gusts [s], > 0
  Airflow airflow{};               ///< between each pair of robots
  double input_delay = 0.0;        ///< from command to effect [s], in [0, 1]
  double yaw_lag = 0.0;            ///< time constant of the input u_psi [s], 0 or >= 1e-3
  double input_gain = 1.0;         ///< model error: true input effect over the model's, > 0
  double slip = 0.0;               ///< of wheels: lost fraction of a rover's translation and turn, in [0,
                                   ///< 0.9]
  Noise noise{};                   ///< of the measurement
  Odometry odometry{};             ///< of robots
  double measurement_delay = 0.0;  ///< from state to measurement [s], in [0, 1]

  /// Whether measurements differ from the true states.
  bool spoil_measurements() const;
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
};

/// Purpose of a random stream.
enum class StreamId : std::uint64_t {
  gust,
  wake,
  position_noise,
  heading_noise,
  velocity_noise,
  motion,
  run,
  draw,
  fault,
  position_drift,
  heading_drift,
  velocity_drift,
  gyro_noise,
  gyro_bias,
  accelerometer_noise,
  accelerometer_bias,
  mounting,
  latency,
  sighting,
  picture
};

/// Random numbers of one seed, purpose and body: SplitMix64, with Box-Muller for normal numbers.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, StreamId purpose, int body);

  double uniform() noexcept;  ///< in (0, 1]
  double normal() noexcept;   ///< mean 0, standard deviation 1
  Vec3<double> normals() noexcept;
  std::uint64_t bits() noexcept;

 private:
  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// Coloured noise: one Ornstein-Uhlenbeck process for each robot and axis, in its exact
/// discretisation
///
///   a(t + s) = a(t) e^{-s/tau} + sigma sqrt(1 - e^{-2s/tau}) n,   a(0) = sigma n,   n normal,
///
/// so that for any step the variance is sigma^2 and the correlation e^{-s/tau}.
class Gusts {
 public:
  Gusts(double sigma, double time, int robots, std::uint64_t seed);

  const Vec3<double>& acceleration(int robot) const noexcept { return a_[static_cast<std::size_t>(robot)]; }
  void advance(double s) noexcept;

 private:
  double sigma_, time_;
  std::vector<RandomStream> streams_;
  std::vector<Vec3<double>> a_;
};

/// Accelerations from the robots' wakes. Each other robot j, at distance D, accelerates robot i by
///
///   amplitude min((distance / D)^2, strongest) sin(phase_j) e
///
/// with e horizontal and normal to the line from j to i. Two robots aligned along x oscillate in y,
/// as in the paper's flight. The phase of each robot advances at `frequency`, from a seeded start
/// and with a slow seeded random walk.
class Wakes {
 public:
  Wakes(const Airflow& airflow, int robots, std::uint64_t seed);

  /// Adds the accelerations [m/s^2] of the robots at these positions [m].
  void push(std::span<const Vec3<double>> p, std::span<Vec3<double>> acceleration) const noexcept;
  void advance(double s) noexcept;

 private:
  Airflow airflow_;
  std::vector<RandomStream> streams_;
  std::vector<double> phase_, swing_;  // [rad], sin(phase)
};

/// Error of the odometry of one robot, as Odometry defines it.
class OdometryErrors {
 public:
  /// @param velocities  number of velocity states of the robot
  OdometryErrors(const Odometry& odometry, std::size_t velocities, std::uint64_t seed, int body);

  void advance(double s) noexcept;

  const Vec3<double>& position() const noexcept { return position_; }  ///< [m]
  double heading() const noexcept { return heading_; }                 ///< [rad]
  /// Error of velocity state i [m/s], whose true value is v [m/s].
  double velocity(std::size_t i, double v) const noexcept { return velocity_[i] + scale_ * v; }

 private:
  Odometry odometry_;
  // Each stream draws its initial values first, even if they are unused.
  RandomStream of_position_, of_heading_, of_velocity_;
  Vec3<double> position_;
  double heading_, scale_;
  std::vector<double> velocity_;
};

/// Queue of delayed commands. Each command comes into force `delay` after give(), also between two
/// steps.
class InputDelay {
 public:
  /// @param period   the shortest time between two commands [s]; of faster ones only the latest is
  /// kept
  /// @param initial  the command in force until the first arrives (nu)
  InputDelay(double delay, double period, std::span<const double> initial);

  void give(double t, std::span<const double> u) noexcept;
  /// The command in force at t [s]; t must not decrease.
  std::span<const double> at(double t) noexcept;
  /// When the next command comes into force [s]; infinity if none is pending. Call after at().
  double next_arrival() const noexcept;

 private:
  std::size_t row(std::size_t ahead) const noexcept { return (held_ + ahead) % arrival_.size(); }

  double delay_;
  std::size_t nu_, held_ = 0, waiting_ = 0;
  std::vector<double> arrival_, rows_;
};

}  // namespace sightline
