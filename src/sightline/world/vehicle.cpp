#include "sightline/vehicle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sightline/base.hpp"
#include "sightline/world.hpp"
#include "sightline/world/mixer.hpp"

namespace sightline {

Vehicle Vehicle::crazyflie() {
  Vehicle v;
  v.mass = 0.0319;
  v.inertia = {16.8e-6, 16.8e-6, 29.8e-6};
  v.rotor_x = {0.0325, -0.0325, 0.0325, -0.0325};
  v.rotor_y = {-0.0325, 0.0325, 0.0325, -0.0325};
  v.rotor_radius = 0.0231;
  v.k_f = 2.88e-8;
  v.k_m = 0.006;
  v.speed_max = 2041.0;
  v.tau_up = v.tau_down = 0.015;
  v.rotor_drag = 0.0;
  v.drag = {0.0147, 0.0147, 0.0147};
  v.radius = 0.07;
  v.height = 0.03;
  return v.set_attitude(15.7, 0.55, v.tau_up);
}

Vehicle Vehicle::ar_drone() {
  Vehicle v;
  constexpr double a = -0.5092, b = 1.458;  // (16)
  v.mass = 0.42;
  v.inertia = {0.0022, 0.0030, 0.0048};
  v.rotor_x = {0.126, -0.126, 0.126, -0.126};
  v.rotor_y = {-0.126, 0.126, 0.126, -0.126};
  v.rotor_radius = 0.1;
  v.k_f = 8.86e-6;
  v.k_m = 0.016;
  v.speed_max = 490.0;
  v.rotor_drag = 0.0;
  v.drag = {-a * v.mass, -a * v.mass, -a * v.mass};
  v.radius = 0.26;
  v.height = 0.13;
  v.attitude_gain = 8.0;
  v.rate_gain = 25.0;
  v.tilt_max = std::atan2(b, gravity);
  v.climb_max = 1.0;
  v.yaw_max = 1.6;
  return v;
}

std::array<Preset<Vehicle>, 3> Vehicle::presets() {
  return {{{"x500", x500()}, {"crazyflie", crazyflie()}, {"ar_drone", ar_drone()}}};
}

double Vehicle::weight() const { return mass * gravity; }

double Vehicle::thrust_max() const { return static_cast<double>(rotors()) * k_f * square(speed_max); }

double Vehicle::hover_speed() const { return sqrt(weight() / (static_cast<double>(rotors()) * k_f)); }

Vec3<double> Vehicle::hover_drag() const {
  const double level = 0.5 * (drag.x + drag.y) + static_cast<double>(rotors()) * rotor_drag * hover_speed();
  return {level, level, drag.z};
}

Vec3<double> Vehicle::air(const Vec3<double>& acceleration) const {
  const Vec3<double> d = hover_drag(), a = mass * acceleration;
  return {a.x != 0 ? a.x / d.x : 0.0, a.y != 0 ? a.y / d.y : 0.0, a.z != 0 ? a.z / d.z : 0.0};
}

// tau s^3 + s^2 + rate s + rate attitude = tau (s^2 + 2 zeta omega s + omega^2)(s + c / tau).
Vehicle& Vehicle::set_attitude(double omega, double zeta, double tau) {
  const double s = 2 * zeta * omega, c = 1 - s * tau;
  rate_gain = s * c + square(omega) * tau;
  attitude_gain = square(omega) * c / rate_gain;
  return *this;
}

void Vehicle::check() const {
  check_parameters(*this);
  if (imu) imu->check();
  const std::size_t n = rotors();
  if (n < rotors_min || n > rotors_max)
    throw_invalid("vehicle.rotor_x has {} rotors, expected {} to {}", n, rotors_min, rotors_max);
  if (rotor_y.size() != n)
    throw_invalid("vehicle.rotor_y has {} numbers, expected {}, as rotor_x", rotor_y.size(), n);
  if (spin.size() != n) throw_invalid("vehicle.spin has {} numbers, expected {}, as rotor_x", spin.size(), n);
  for (const double s : spin) {
    if (s != 1 && s != -1) throw_invalid("vehicle.spin = {}, expected 1 or -1 for each rotor", s);
  }
  if (inertia.x + inertia.y < inertia.z || inertia.y + inertia.z < inertia.x ||
      inertia.z + inertia.x < inertia.y)
    throw_invalid(
        "vehicle.inertia = [{}, {}, {}] kg m^2, expected none greater than the sum of the other two",
        inertia.x, inertia.y, inertia.z);

  // Hover needs equal thrusts without torque; control needs a torque about each axis.
  const auto sum = [](const std::vector<double>& all) {
    return std::accumulate(all.begin(), all.end(), 0.0);
  };
  double arm = 0.0;
  for (std::size_t i = 0; i < n; ++i) arm = std::max(arm, norm(rotor_x[i], rotor_y[i]));
  const auto balanced = [&](double total) { return std::abs(total) <= 1e-3 * arm; };
  if (!balanced(sum(rotor_x)))
    throw_invalid("vehicle.rotor_x sums to {} m, expected 0: equal thrusts would pitch it", sum(rotor_x));
  if (!balanced(sum(rotor_y)))
    throw_invalid("vehicle.rotor_y sums to {} m, expected 0: equal thrusts would roll it", sum(rotor_y));
  if (sum(spin) != 0)
    throw_invalid("vehicle.spin sums to {}, expected 0: equal thrusts would yaw it", sum(spin));
  if (!Mixer::steers(*this))
    throw_invalid(
        "vehicle.rotor_x, rotor_y and spin leave an axis without torque, expected one about each of x, y, z");

  const double lift = thrust_max() / weight();
  if (!(lift >= 1.1)) {
    throw_invalid(
        "vehicle.mass = {} kg with {} rotors that lift {:.4g} N: thrust to weight {:.3g}, expected at least "
        "1.1",
        mass, n, thrust_max(), lift);
  }
  const double slow = std::max(tau_up, tau_down);
  if (attitude_gain * slow >= 0.5) {
    throw_invalid(
        "vehicle.attitude_gain = {:.4g} 1/s with rotors that lag by {} s, expected below {:.4g} 1/s",
        attitude_gain, slow, 0.5 / slow);
  }
}

std::string describe(const RobotVehicle& vehicle) {
  const Vehicle& v = vehicle.vehicle;
  const std::string body =
      vehicle.model ? fmt::format(" as {} of {}", vehicle.model->body, vehicle.model->file.name) : "";
  return fmt::format("{}{}, {:.6g} kg, {} rotors, thrust to weight {:.2f}{}", vehicle.preset, body, v.mass,
                     v.rotors(), v.thrust_max() / v.weight(), v.imu ? ", an IMU with errors" : "");
}

}  // namespace sightline
