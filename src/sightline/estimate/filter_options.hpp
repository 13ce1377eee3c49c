/// Noise assumptions and options of the pose filters.
#pragma once

#include <array>
#include <string_view>

#include "sightline/base/parameter.hpp"

namespace sightline {

enum class FilterKind {
  heading,   ///< position and heading; roll and pitch are inputs (HeadingFilter)
  attitude,  ///< position, velocity and attitude from an inertial measurement unit (AttitudeFilter)
  chain,     ///< `heading` for a robot that observes a robot which is itself localized (ChainFilter)
};
inline constexpr std::array<std::string_view, 3> filter_kinds = {"heading", "attitude", "chain"};

/// Standard deviations of the motion that a robot's autopilot reports. White noise is that of a
/// mean over 10 ms (`white_period`); over dt it is smaller by sqrt(0.01 s / dt). A bias is a
/// Gauss-Markov process with this standard deviation and correlation time, or a random walk that
/// starts with it.
struct FilterOptions {
  static constexpr std::string_view name = "estimate";
  static constexpr double white_period = 0.01;  // [s]
  static constexpr double compass_rate = 10.0;  // [Hz]

  FilterKind filter = FilterKind::heading;
  double velocity_noise = 0.05;
  double velocity_bias = 0.08;
  double velocity_bias_time = 15.0;
  double yaw_rate_noise = 0.01;
  double yaw_rate_bias = 0.02;
  double yaw_rate_walk = 2e-4;
  double tilt_noise = 0.003;
  double tilt_bias = 0.012;
  double tilt_time = 10.0;
  double gyro_noise = 0.005;
  double gyro_bias = 0.02;
  double gyro_walk = 2e-4;
  double accelerometer_noise = 0.08;
  double accelerometer_bias = 0.1;
  double accelerometer_walk = 2e-3;
  double compass_noise = 0.0;
  double camera_turn = 0.0;
  double other_error_time = 2.0;
  double other_error_spread = 1.0;
  int start_sightings = 3;
  int restart_sightings = 8;

  static constexpr auto parameters() {
    using O = FilterOptions;
    constexpr Bounds count = {1, 32, "1 to 32"};
    return std::tuple{
        parameter("filter", &O::filter, filter_kinds,
                  "position and heading, or the whole attitude by an inertial measurement unit"),
        parameter("velocity_noise", &O::velocity_noise, "m/s", above_zero,
                  "white noise of the measured velocity, each axis, mean over 10 ms"),
        parameter("velocity_bias", &O::velocity_bias, "m/s", from_zero, "its bias, each axis"),
        parameter("velocity_bias_time", &O::velocity_bias_time, "s", above_zero,
                  "correlation time of that bias"),
        parameter("yaw_rate_noise", &O::yaw_rate_noise, "rad/s", above_zero,
                  "white noise of the yaw rate, mean over 10 ms; heading filter"),
        parameter("yaw_rate_bias", &O::yaw_rate_bias, "rad/s", from_zero, "its bias at the start"),
        parameter("yaw_rate_walk", &O::yaw_rate_walk, "rad/s/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("tilt_noise", &O::tilt_noise, "rad", from_zero,
                  "white noise of roll and pitch; heading filter"),
        parameter("tilt_bias", &O::tilt_bias, "rad", from_zero, "slow error of roll and pitch"),
        parameter("tilt_time", &O::tilt_time, "s", above_zero, "correlation time of that error"),
        parameter("gyro_noise", &O::gyro_noise, "rad/s", above_zero,
                  "white noise of the gyroscope, each axis, mean over 10 ms; attitude filter"),
        parameter("gyro_bias", &O::gyro_bias, "rad/s", from_zero, "its bias at the start"),
        parameter("gyro_walk", &O::gyro_walk, "rad/s/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("accelerometer_noise", &O::accelerometer_noise, "m/s^2", above_zero,
                  "white noise of the accelerometer, each axis, mean over 10 ms; attitude filter"),
        parameter("accelerometer_bias", &O::accelerometer_bias, "m/s^2", from_zero, "its bias at the start"),
        parameter("accelerometer_walk", &O::accelerometer_walk, "m/s^2/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("compass_noise", &O::compass_noise, "rad", from_zero,
                  "white noise of the heading by a compass, 10 times a second; 0: it has none"),
        parameter("camera_turn", &O::camera_turn, "rad", from_zero,
                  "turn of the camera against its mount, each axis, that is estimated; 0: it is known; "
                  "attitude filter"),
        parameter("other_error_time", &O::other_error_time, "s", above_zero,
                  "correlation time of the error of a body that is localized itself; chain filter"),
        parameter("other_error_spread", &O::other_error_spread, "", {1, 100, "1 to 100"},
                  "factor by which that time may be off, either way; chain filter"),
        parameter("start_sightings", &O::start_sightings, "", count,
                  "sightings that must mean the same place before there is an estimate"),
        parameter(
            "restart_sightings", &O::restart_sightings, "", count,
            "refused sightings that mean the same place, without an accepted one between, after which the "
            "filter begins anew")};
  }

  bool operator==(const FilterOptions&) const = default;

  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
};

}  // namespace sightline
