/// Disturbances of a flight: wind, gusts, the robots' wakes, delayed and lagging commands, noise and drift of what is measured. All
/// seeded.
///
/// Each source has a random stream of its own, from seed, kind and body, so that switching one
/// disturbance on leaves the others' numbers as they were. Same seed and binary: same numbers.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/base/fixed.hpp"
#include "sightline/base/parameter.hpp"

namespace sightline {

/// The wakes of robots in hover, section 7.2: each swings slowly and shakes the others, the more the nearer.
struct Airflow {
  double amplitude = 0.0;  ///< acceleration felt at `distance` [m/s^2], >= 0
  double distance =
      1.5;  ///< [m], > 0; nearer by a factor q the push is q^2 stronger, at most `strongest` times
  double frequency = 0.5;  ///< of the swinging [Hz], >= 0

  static constexpr double strongest = 4.0;
  static constexpr double wander = 0.3;  ///< of the phase [rad/sqrt(s)]: coherent over about ten seconds
};

/// Standard deviations of a measurement; independent from one measurement to the next.
struct Noise {
  double position = 0.0;  ///< each axis [m], >= 0
  double heading = 0.0;   ///< [rad], >= 0
  double velocity = 0.0;  ///< each axis [m/s], >= 0
};

/// Errors of the robots' own odometry, beside the noise. What a robot measures is off by
///
///   position, heading   b(t)                     b(t) = b_0 + random walk
///   velocity v          b(t) + scale v           of each velocity among its states
///
/// b_0 and scale are drawn once for a flight, with the standard deviations `..._bias` and `velocity_scale`; a walk of density K has moved
/// by K sqrt(t) after t. The errors are independent: the position is not the integral of the velocity that is measured.
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

/// All that disturbs a simulated flight. The default disturbs nothing.
struct Disturbances {
  Vec3<double> wind{};             ///< steady acceleration in G [m/s^2]
  double gust_sigma = 0.0;         ///< of each horizontal and vertical axis [m/s^2], >= 0
  double gust_time = 1.0;          ///< correlation time of the gusts [s], > 0
  Airflow airflow{};               ///< between each two robots
  double input_delay = 0.0;        ///< from command to effect [s], in [0, 1]
  double yaw_lag = 0.0;            ///< time constant of the input u_psi [s], 0 or >= 1e-3
  double input_gain = 1.0;         ///< error of the model: what the inputs do, over what the model says, > 0
  double slip = 0.0;               ///< of wheels: part of a rover's way and turn that is lost, in [0, 0.9]
  Noise noise{};                   ///< of the measurement
  Odometry odometry{};             ///< of robots
  double measurement_delay = 0.0;  ///< from state to measurement [s], in [0, 1]

  /// Whether what is measured differs from what is true.
  bool spoil_measurements() const;
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
};

/// What a stream of random numbers is for.
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

/// Random numbers of one seed, purpose and body: SplitMix64, and Box-Muller on top.
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

/// Coloured noise, one Ornstein-Uhlenbeck process for each robot and axis, in its exact discretisation
///
///   a(t + s) = a(t) e^{-s/tau} + sigma sqrt(1 - e^{-2s/tau}) n,   a(0) = sigma n,   n normal,
///
/// so that the variance is sigma^2 and the correlation e^{-s/tau} for any step.
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

/// The push of the robots' wakes. Robot i feels of each other robot j, at distance D,
///
///   amplitude min((distance / D)^2, strongest) sin(phase_j) e,   e across the line from j to i, horizontal:
///
/// with the two lined up along x, both swing in y, as the paper's flight shows. The phase of each robot runs
/// at `frequency`, from a seeded start and with a slow seeded wander.
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

/// What the odometry of one robot is off by, as Odometry says.
class OdometryErrors {
 public:
  /// @param velocities  how many of its states are one
  OdometryErrors(const Odometry& odometry, std::size_t velocities, std::uint64_t seed, int body);

  void advance(double s) noexcept;

  const Vec3<double>& position() const noexcept { return position_; }  ///< [m]
  double heading() const noexcept { return heading_; }                 ///< [rad]
  /// Of the velocity of that number, which is v [m/s].
  double velocity(std::size_t i, double v) const noexcept { return velocity_[i] + scale_ * v; }

 private:
  Odometry odometry_;
  // What is drawn at the start comes first in each, asked for or not.
  RandomStream of_position_, of_heading_, of_velocity_;
  Vec3<double> position_;
  double heading_, scale_;
  std::vector<double> velocity_;
};

/// Commands on their way to the robot; each comes into force `delay` after it was given, wherever that falls
/// between two steps.
class InputDelay {
 public:
  /// @param period   the shortest time between two commands [s]; of faster ones only the latest is kept
  /// @param initial  the command in force until the first arrives (nu)
  InputDelay(double delay, double period, std::span<const double> initial);

  void give(double t, std::span<const double> u) noexcept;
  /// The command in force at t [s]; t must not fall.
  std::span<const double> at(double t) noexcept;
  /// When the next command comes into force [s]; infinity where none is on its way. After at().
  double next_arrival() const noexcept;

 private:
  std::size_t row(std::size_t ahead) const noexcept { return (held_ + ahead) % arrival_.size(); }

  double delay_;
  std::size_t nu_, held_ = 0, waiting_ = 0;
  std::vector<double> arrival_, rows_;
};

}  // namespace sightline
