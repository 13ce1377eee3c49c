#include "sightline/world/flight_controller.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"

namespace sightline {
namespace {

struct Commanded {
  std::string_view robot;
  Commands commands;
};
constexpr std::array<Commanded, 5> commanded = {{{Multirotor::name, Commands::tilt},
                                                 {AngleMultirotor::name, Commands::tilt},
                                                 {HoverMultirotor::name, Commands::tilt},
                                                 {VelocityMultirotor::name, Commands::velocity},
                                                 {PointMass::name, Commands::full_state}}};

constexpr double steepest = 1.2;             // bound of the commanded tilt, for inputs beyond 1 [rad]
constexpr double climb_most = 4.0;           // vertical acceleration [m/s^2]
constexpr double climb_integral_most = 2.0;  // [m/s^2]
constexpr double least_lift = 0.5;           // smallest cosine of the tilt that the collective compensates
constexpr double damping_rate = 30.0;        // of the filter of the acceleration [1/s]
constexpr double lead_p_most = 0.5;          // distance of a full-state trajectory from the body [m]
constexpr double lead_v_most = 1.0;          // [m/s]
constexpr double heading_gain = 2.0;         // yaw rate over heading, under full-state commands [1/s]

/// The point nearest to `to` within the distance `most` of `from`.
Vec3<double> within(const Vec3<double>& to, const Vec3<double>& from, double most) noexcept {
  const Vec3<double> way = to - from;
  const double length = norm(way);
  return length > most ? from + (most / length) * way : to;
}

}  // namespace

std::optional<Commands> commands_of(const Model& robot) {
  for (const Commanded& one : commanded) {
    if (one.robot == robot.name()) return one.commands;
  }
  return std::nullopt;
}

std::string robots_with_vehicles(std::span<const Commands> of) {
  std::vector<std::string_view> names;
  for (const Commanded& one : commanded) {
    if (of.empty() || std::find(of.begin(), of.end(), one.commands) != of.end()) names.push_back(one.robot);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

FlightController::FlightController(const Vehicle& vehicle, Commands commands)
    : vehicle_(vehicle), commands_(commands), mixer_(vehicle) {}

void FlightController::begin() noexcept {
  climb_integral_ = 0.0;
  velocity_integral_ = acceleration_ = v_before_ = {};
  first_ = true;
}

/// Advances the trajectory of full-state commands by one period.
void FlightController::lead(const RigidBody& body, const Vec3<double>& a) noexcept {
  if (first_) lead_p_ = body.p, lead_v_ = body.v;
  lead_v_ = within(lead_v_ + period * a, body.v, lead_v_most);
  lead_p_ = within(lead_p_ + period * lead_v_, body.p, lead_p_most);
}

/// Horizontal acceleration in G: PID on the velocity plus the commanded acceleration `ahead`.
Vec3<double> FlightController::velocity_acceleration(const RigidBody& body, const Vec3<double>& wanted,
                                                     const Vec3<double>& ahead) noexcept {
  const Vec2<double> error = {wanted.x - body.v.x, wanted.y - body.v.y};
  if (first_) v_before_ = {body.v.x, body.v.y};
  first_ = false;
  constexpr double share = damping_rate * period;
  acceleration_.x += share * ((body.v.x - v_before_.x) / period - acceleration_.x);
  acceleration_.y += share * ((body.v.y - v_before_.y) / period - acceleration_.y);
  v_before_ = {body.v.x, body.v.y};
  const Vehicle& c = vehicle_;
  const auto part = [&](double missing, double integral, double rate, double requested) {
    return c.velocity_gain * missing + integral - c.velocity_damping * (rate - requested) + requested;
  };
  Vec3<double> a = {part(error.x, velocity_integral_.x, acceleration_.x, ahead.x),
                    part(error.y, velocity_integral_.y, acceleration_.y, ahead.y), 0.0};
  const double most = gravity * std::tan(c.tilt_limit), size = norm(a.x, a.y);
  if (size > most) return (most / size) * a;  // anti-windup: the integral is not updated
  velocity_integral_.x += c.velocity_integral * period * error.x;
  velocity_integral_.y += c.velocity_integral * period * error.y;
  return a;
}

Thrusts FlightController::update(const RigidBody& body, const Rotation& R,
                                 const std::array<double, 4>& u) noexcept {
  const Vehicle& c = vehicle_;
  const Vec2<double> d = heading(R);
  const bool tilts = commands_ == Commands::tilt;

  Vec3<double> wanted{}, ahead{};  // velocity and acceleration, in G
  double yaw_rate = 0.0;
  if (tilts) {
    wanted.z = c.climb_max * u[2];
    yaw_rate = c.yaw_max * u[3];
  } else if (commands_ == Commands::velocity) {
    const Vec2<double> v = rotate<double>(d, {u[0], u[1]});
    wanted = {v.x, v.y, u[2]};
    yaw_rate = u[3];
  } else {
    ahead = {u[0], u[1], u[2]};
    lead(body, ahead);
    wanted = lead_v_ + c.position_gain * (lead_p_ - body.p);
    yaw_rate = std::clamp(-heading_gain * atan2(d.y, d.x), -c.yaw_max, c.yaw_max);
  }

  // Climb first: velocity and full-state commands add its acceleration to the thrust direction.
  const double climb_error = wanted.z - body.v.z;
  climb_integral_ = std::clamp(climb_integral_ + c.climb_integral * period * climb_error,
                               -climb_integral_most, climb_integral_most);
  const double climb =
      std::clamp(c.climb_gain * climb_error + climb_integral_ + ahead.z, -climb_most, climb_most);

  Vec3<double> push;
  if (tilts) {
    const auto level_push = [&](double part) {
      return gravity * std::tan(std::clamp(c.tilt_max * part, -steepest, steepest));
    };
    const Vec2<double> a = rotate<double>(d, {level_push(u[0]), -level_push(u[1])});
    push = {a.x, a.y, gravity};
  } else {
    push = velocity_acceleration(body, wanted, ahead);
    push.z = gravity + climb;
  }

  // The shortest rotation that aligns the thrust with `push`.
  const Vec3<double> to = R.to_B((1 / norm(push)) * push);
  const double sine = norm(to.x, to.y);
  const double turn = c.attitude_gain * (sine > 1e-9 ? atan2(sine, to.z) / sine : 1.0);
  const Vec3<double> rate = {-turn * to.y + yaw_rate * R.x.z, turn * to.x + yaw_rate * R.y.z,
                             yaw_rate * R.z.z};
  const Vec3<double> error = rate - body.w, I = body.inertia;
  const Vec3<double> spin = {I.x * body.w.x, I.y * body.w.y, I.z * body.w.z};
  const Vec3<double> torque =
      Vec3<double>{I.x * c.rate_gain * error.x, I.y * c.rate_gain * error.y, I.z * c.yaw_gain * error.z} +
      cross(body.w, spin);
  return mixer_(c.mass * (gravity + climb) / std::max(least_lift, R.z.z), torque);
}

}  // namespace sightline
