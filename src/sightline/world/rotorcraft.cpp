#include "sightline/world/rotorcraft.hpp"

#include <algorithm>

namespace sightline {
namespace {

constexpr std::int64_t ticks_per_control = 2;
static_assert(FlightController::period == ticks_per_control * rotorcraft_step);

constexpr double touch_depth = 1e-6;  // a smaller depth is rounding, not contact [m]

const Vehicle& checked(const Vehicle& vehicle) {
  vehicle.check();
  return vehicle;
}

}  // namespace

Rotorcraft::Rotorcraft(const Vehicle& vehicle, Commands commands, std::uint64_t seed, int body)
    : vehicle_(checked(vehicle)),
      controller_(vehicle, commands),
      body_{.mass = vehicle.mass, .inertia = vehicle.inertia},
      rotors_(vehicle.rotors()),
      rise_(1 - exp(-rotorcraft_step / vehicle.tau_up)),
      fall_(1 - exp(-rotorcraft_step / vehicle.tau_down)) {
  if (vehicle.imu) inertial_.emplace(*vehicle.imu, seed, body);
  begin({}, {1, 0}, {}, 0.0);
}

void Rotorcraft::begin(const Vec3<double>& p, const Vec2<double>& d, const Vec3<double>& v,
                       double yaw_rate) noexcept {
  body_.p = p, body_.v = v, body_.w = {0, 0, yaw_rate};
  body_.q = upright(d);
  speed_.fill(0.0);
  std::fill_n(speed_.begin(), rotors_, vehicle_.hover_speed());
  controller_.begin();
  if (inertial_) inertial_->begin(attitude());
  ticks_ = 0;
  crash_speed_ = 0.0;
}

void Rotorcraft::step(const std::array<double, 4>& u, const Vec3<double>& air) noexcept {
  const Wrench wrench = push(u, air);
  body_.step(wrench.force + Vec3<double>{0, 0, -vehicle_.weight()}, wrench.torque, rotorcraft_step);
  meet_ground();
}

Wrench Rotorcraft::push(const std::array<double, 4>& u, const Vec3<double>& air) noexcept {
  const Rotation R = attitude();
  if (ticks_++ % ticks_per_control == 0) control(R, u);
  spin_up(wanted_);

  const double now = k_f();
  double lift = 0.0, speeds = 0.0;
  Vec3<double> torque{};
  for (std::size_t i = 0; i < rotors_; ++i) {
    const double f = now * square(speed_[i]);
    lift += f;
    speeds += speed_[i];
    torque = torque +
             f * Vec3<double>{vehicle_.rotor_y[i], -vehicle_.rotor_x[i], -vehicle_.spin[i] * vehicle_.k_m};
  }
  const Vec3<double> wind = R.to_B(body_.v - air), &drag = vehicle_.drag;
  const double in_plane = vehicle_.rotor_drag * speeds;
  const Vec3<double> force = {-(drag.x + in_plane) * wind.x, -(drag.y + in_plane) * wind.y,
                              lift - drag.z * wind.z};
  return {R.to_G(force), torque};
}

void Rotorcraft::control(const Rotation& R, const std::array<double, 4>& u) noexcept {
  if (!inertial_) {
    wanted_ = controller_.update(body_, R, u);
    return;
  }
  inertial_->advance(R, FlightController::period);
  const RigidBody body = seen();
  wanted_ = controller_.update(body, rotation(body.q), u);
}

/// Thrust coefficient at the present battery charge, which is unknown to the flight controller.
double Rotorcraft::k_f() const noexcept {
  const double used = std::min(1.0, static_cast<double>(ticks_) * rotorcraft_step / vehicle_.battery_time);
  return vehicle_.k_f * (1.0 - vehicle_.battery_sag * used);
}

void Rotorcraft::spin_up(const Thrusts& wanted) noexcept {
  for (std::size_t i = 0; i < rotors_; ++i) {
    const double goal = sqrt(wanted[i] / vehicle_.k_f);
    speed_[i] += (goal > speed_[i] ? rise_ : fall_) * (goal - speed_[i]);
  }
}

void Rotorcraft::meet_ground() noexcept {
  if (!(body_.p.z < -touch_depth)) return;
  const double speed = norm(body_.v);
  if (speed > landing_speed_max) crash_speed_ = std::max(crash_speed_, speed);
  body_.p.z = 0.0;
  body_.v = body_.w = {};
  body_.q = upright(heading());
}

double Rotorcraft::thrust() const {
  double lift = 0.0;
  for (const double s : speed_) lift += vehicle_.k_f * square(s);
  return lift;
}

double Rotorcraft::lift() const { return thrust() * (k_f() / vehicle_.k_f); }

}  // namespace sightline
