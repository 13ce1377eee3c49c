#include "bridges/dds/simulators/simulated_body.hpp"

#include <algorithm>
#include <cmath>

#include "bridges/dds/simulators/vehicle_simulator.hpp"

namespace sightline::dds {
namespace {

constexpr double body_lag = 0.3, body_yaw_lag = 0.1, push_most = 6.0;  // [s], [s], [m/s^2]

constexpr double climb_most = 1.5, sink = 0.7;  // [m/s]
constexpr double near_ground = 0.1;             // [m]

}  // namespace

double takeoff_speed(double height, double altitude) noexcept {
  return std::clamp(1.5 * (altitude - height) + 0.05, 0.0, climb_most);
}

double landing_speed(double height) noexcept { return height > near_ground ? -sink : -sink / 2; }

SimulatedBody::SimulatedBody(const Vec3<double>& p, double heading, const std::optional<Vehicle>& rotors,
                             Commands commands)
    : rotorcraft_(rotors ? std::make_unique<Rotorcraft>(*rotors, commands) : nullptr),
      motion_{p, upright({std::cos(heading), std::sin(heading)}), {}, 0.0} {
  rest();
}

void SimulatedBody::rest() noexcept {
  motion_.r = 0.0;
  motion_.v =
      on_ground() ? Vec3<double>{} : motion_.v + Vec3<double>{0, 0, -gravity * VehicleSimulator::period};
  motion_.p = motion_.p + VehicleSimulator::period * motion_.v;
  if (motion_.p.z < 0) motion_.p.z = 0, motion_.v = {};
  if (rotorcraft_) rotorcraft_->begin(motion_.p, heading(rotation(motion_.q)), motion_.v, 0.0);
}

void SimulatedBody::follow(const Vec3<double>& v, const Vec3<double>& a, double r) noexcept {
  if (rotorcraft_) {
    const Vehicle& vehicle = rotorcraft_->vehicle();  // its loops turn v into a, too
    const Vec2<double> d = rotorcraft_->heading();
    const Vec2<double> u =
        rotate<double>({d.x, -d.y}, {v.x + a.x / vehicle.velocity_gain, v.y + a.y / vehicle.velocity_gain});
    fly({u.x, u.y, v.z + a.z / vehicle.climb_gain, r});
    return;
  }
  // Exact for a command held over one period: the velocity at its end, and its mean.
  constexpr double dt = VehicleSimulator::period;
  struct Step {
    double end, mean;
  };
  const auto toward = [](double now, double to, double lag) {
    const double gone = -std::expm1(-dt / lag);
    return Step{now + gone * (to - now), to + (now - to) * gone * lag / dt};
  };
  const auto pushed = [&](double now, double to, double push) {
    const Step step = toward(now, to + body_lag * push, body_lag);
    const double most = dt * push_most, change = std::clamp(step.end - now, -most, most);
    return change == step.end - now ? step : Step{now + change, now + change / 2};
  };
  const Vec3<double> now = motion_.v;
  const Step x = pushed(now.x, v.x, a.x), y = pushed(now.y, v.y, a.y), z = pushed(now.z, v.z, a.z),
             rate = toward(motion_.r, r, body_yaw_lag);
  motion_.v = {x.end, y.end, z.end};
  motion_.p = motion_.p + dt * Vec3<double>{x.mean, y.mean, z.mean};
  motion_.r = rate.end;
  const double turn = dt * rate.mean;
  motion_.q = Quaternion{std::cos(turn / 2), 0, 0, std::sin(turn / 2)} * motion_.q;
  if (motion_.p.z < 0) motion_.p.z = 0, motion_.v = {};
}

void SimulatedBody::tilt(const std::array<double, 4>& u) noexcept { fly(u); }

void SimulatedBody::fly(const std::array<double, 4>& u) noexcept {
  for (std::int64_t i = std::llround(VehicleSimulator::period / rotorcraft_step); i > 0; --i)
    rotorcraft_->step(u, {});
  motion_ = {rotorcraft_->body().p, rotorcraft_->body().q, rotorcraft_->body().v,
             rotorcraft_->heading_rate()};
}

}  // namespace sightline::dds
