#include "sightline/world/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

double get(const double* x, int state) noexcept { return state >= 0 ? x[state] : 0.0; }
void set(double* x, int state, double value) noexcept {
  if (state >= 0) x[state] = value;
}

/// Writes what an IMU measures: the heading rate and the accelerations of the tilt.
void write_sensed(const StateRoles& roles, const RigidBody& body, double* x) noexcept {
  const Rotation R = rotation(body.q);
  const Vec2<double> d = heading(R);
  const double lean = gravity / std::max(R.z.z, 0.1);  // bounded for every attitude
  const Vec2<double> a = rotate<double>({d.x, -d.y}, {lean * R.z.x, lean * R.z.y});
  set(x, roles.rate, heading_rate(R, body.w));
  set(x, roles.tilt[0], a.x), set(x, roles.tilt[1], a.y);
}

}  // namespace

Fleet::Fleet(const Team& team, const std::vector<RobotVehicle>& vehicles, const PlantOptions& plant)
    : pool_(thread_pool_if(static_cast<int>(vehicles.size()) >= PlantOptions::vehicles_shared_from,
                           plant.pool)),
      downwash_(plant.downwash.scale),
      jets_(vehicles.size()),
      craft_of_(size(team.bodies()), -1) {
  for (const RobotVehicle& one : vehicles) {
    if (one.robot.index < 0 || one.robot.index >= team.bodies() || !team.is_agent(one.robot))
      throw_invalid("a vehicle is of body {}, expected a robot of the team", one.robot.index);
    const Model& model = team.model(one.robot);
    const std::optional<Commands> commands = commands_of(model);
    if (!commands)
      throw_invalid("{} is of the kind {}, expected one that a vehicle can be: {}", team.name(one.robot),
                    model.name(), robots_with_vehicles());
    StateRoles roles = roles_of(model);
    if (!roles.others.empty())
      throw_invalid("the state {} of {} is none that a vehicle shows", model.states()[at(roles.others[0])],
                    model.name());
    int& craft = craft_of_[at(one.robot)];
    if (craft >= 0) throw_invalid("{} is two vehicles, expected one", team.name(one.robot));
    craft = static_cast<int>(crafts_.size());
    crafts_.push_back({.robot = one.robot,
                       .flown = Rotorcraft(one.vehicle, *commands, plant.seed, one.robot.index),
                       .roles = std::move(roles),
                       .inputs = model.nu()});
  }
}

const Rotorcraft* Fleet::rotorcraft(BodyId robot) const noexcept {
  if (robot.index < 0 || at(robot) >= craft_of_.size() || craft_of_[at(robot)] < 0) return nullptr;
  return &crafts_[size(craft_of_[at(robot)])].flown;
}

void Fleet::begin(BodyId robot, double, const double* x) noexcept {
  Craft& craft = crafts_[size(craft_of_[at(robot)])];
  const StateRoles& of = craft.roles;
  const double psi = get(x, of.angle);
  const Vec2<double> d = of.direction[0] < 0 ? Vec2<double>{cos(psi), sin(psi)}
                                             : Vec2<double>{x[of.direction[0]], x[of.direction[1]]};
  const Vec2<double> v = rotate<double>(d, {get(x, of.velocity_V[0]), get(x, of.velocity_V[1])});
  const auto in_G = [x](const std::array<int, 3>& states) {
    return Vec3<double>{get(x, states[0]), get(x, states[1]), get(x, states[2])};
  };
  craft.flown.begin(in_G(of.position), d, Vec3<double>{v.x, v.y, 0.0} + in_G(of.velocity_G), get(x, of.rate));
}

void Fleet::steer(BodyId robot, const double* u, const Vec3<double>& acceleration) noexcept {
  Craft& craft = crafts_[size(craft_of_[at(robot)])];
  std::copy_n(u, craft.inputs, craft.commands.begin());
  craft.wind = craft.air = craft.flown.vehicle().air(acceleration);
  craft.steered = true;
}

void Fleet::move(double t) noexcept {
  const std::int64_t until = std::llround(t / rotorcraft_step);
  while (tick_ < until) {
    const bool blows = downwash_ > 0;
    const std::int64_t steps = blows ? std::min(until - tick_, downwash_steps) : until - tick_;
    if (blows) blow();
    advance(steps);
    tick_ += steps;
  }
  for (Craft& craft : crafts_) craft.steered = false;
}

/// Evaluates the air velocity at each vehicle from the jets of all others.
void Fleet::blow() noexcept {
  for (std::size_t i = 0; i < crafts_.size(); ++i) {
    const Rotorcraft& one = crafts_[i].flown;
    const Vehicle& v = one.vehicle();
    jets_[i] = {.p = one.body().p,
                .down = -1.0 * one.attitude().z,
                .thrust = crafts_[i].steered ? one.lift() : 0.0,
                .radius2 = v.disc_radius2(),
                .v = one.body().v};
  }
  pool_->share(static_cast<int>(crafts_.size()), [&](int i, int) noexcept {
    Craft& below = crafts_[at(i)];
    if (!below.steered) return;
    Vec3<double> pushed{};
    for (std::size_t j = 0; j < jets_.size(); ++j) {
      if (j != at(i) && jets_[j].thrust > 0) pushed = pushed + jets_[j].air(below.flown.body().p);
    }
    below.air = below.wind + downwash_ * pushed;
  });
}

void Fleet::show(BodyId robot, double* x) const noexcept {
  const Craft& craft = crafts_[size(craft_of_[at(robot)])];
  const StateRoles& of = craft.roles;
  const RigidBody& body = craft.flown.body();
  const Vec2<double> d = heading(rotation(body.q)), v = rotate<double>({d.x, -d.y}, {body.v.x, body.v.y});
  const auto set_G = [x](const std::array<int, 3>& states, const Vec3<double>& of_body) {
    set(x, states[0], of_body.x), set(x, states[1], of_body.y), set(x, states[2], of_body.z);
  };
  set_G(of.position, body.p), set_G(of.velocity_G, body.v);
  set(x, of.direction[0], d.x), set(x, of.direction[1], d.y);
  set(x, of.angle, atan2(d.y, d.x));
  set(x, of.velocity_V[0], v.x), set(x, of.velocity_V[1], v.y);
  write_sensed(of, body, x);
}

void Fleet::sense(BodyId robot, double* x) const noexcept {
  const Craft& craft = crafts_[size(craft_of_[at(robot)])];
  if (craft.flown.vehicle().imu) write_sensed(craft.roles, craft.flown.seen(), x);
}

}  // namespace sightline
