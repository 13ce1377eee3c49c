/// A flight whose model is known, and the log that PX4 would write of it.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "sightline/base.hpp"
#include "tests/support/ulog.hpp"

namespace sightline::test {

/// A vehicle whose velocity, climb and yaw rate follow random steps by lags of first order.
struct LaggingFlight {
  struct Row {
    double t;
    Vec3<double> p, v, u;
    double psi, r, u_psi;
  };
  static constexpr double step = 0.002, tau = 0.3, tau_z = 0.4, tau_psi = 0.2;  // [s]
  std::vector<Row> rows;

  explicit LaggingFlight(double seconds) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> any(-1, 1);
    Row now{100.0, {1, 2, 3}, {}, {}, 3.0, 0, 0};
    for (int k = 0; step * k <= seconds; ++k) {
      if (k % 350 == 0) now.u = {any(random), any(random), 0.5 * any(random)}, now.u_psi = any(random);
      rows.push_back(now);
      const Vec3<double> off = now.u - now.v;
      now.p = now.p + step * now.v;
      now.psi += step * now.r;
      now.v = now.v + step * Vec3<double>{off.x / tau, off.y / tau, off.z / tau_z};
      now.r += step * (now.u_psi - now.r) / tau_psi;
      now.t = 100.0 + step * (k + 1);
    }
  }
};

struct Px4Flags {
  std::uint8_t arming = 2, mode = 14;
  double reset_at = 1e9;  // [s]
};

/// The log that PX4 would write of the flight, with set-points at each `every`-th step.
inline std::string ulog_of(const LaggingFlight& flight, int every, const Px4Flags& flags = {}) {
  std::string log = ulog_head() + ulog_flags();
  log += ulog_message(
      'F',
      "vehicle_local_position:uint64_t timestamp;uint64_t timestamp_sample;float x;float y;float "
      "z;float vx;float vy;float vz;float heading;bool xy_valid;uint8_t xy_reset_counter;");
  log += ulog_message(
      'F', "trajectory_setpoint:uint64_t timestamp;float[3] position;float[3] velocity;float yawspeed;");
  log += ulog_message('F', "vehicle_status:uint64_t timestamp;uint8_t arming_state;uint8_t nav_state;");
  log += ulog_topic(0, "vehicle_local_position") + ulog_topic(1, "trajectory_setpoint") +
         ulog_topic(2, "vehicle_status");
  log += ulog_data(2, std::uint64_t{1'000'000}, flags.arming, flags.mode);
  const float unset = std::nanf("");
  const auto f = [](double x) { return static_cast<float>(x); };
  for (std::size_t k = 0; k < flight.rows.size(); ++k) {
    const LaggingFlight::Row& row = flight.rows[k];
    const auto time = static_cast<std::uint64_t>(std::llround(1e6 * row.t));
    // NED: north, east, down; the heading is clockwise from north.
    if (k % 4 == 0)
      log += ulog_data(0, time + 3000, time, f(row.p.y), f(row.p.x), f(-row.p.z), f(row.v.y), f(row.v.x),
                       f(-row.v.z), f(wrap(std::numbers::pi / 2 - row.psi)), true,
                       std::uint8_t{row.t > flags.reset_at});
    if (k % static_cast<std::size_t>(every) == 0)
      log += ulog_data(1, time, unset, unset, unset, f(row.u.y), f(row.u.x), f(-row.u.z), f(-row.u_psi));
  }
  return log;
}

}  // namespace sightline::test
