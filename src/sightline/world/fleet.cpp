#include "sightline/world/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

/// Numbers that a vehicle provides, by the state names of planning models.
constexpr std::array<std::string_view, 14> shown_names = {"p_x", "p_y", "p_z", "d_x", "d_y", "psi", "v_f",
                                                          "v_s", "v_x", "v_y", "v_z", "r",   "a_f", "a_s"};
using ShownNumbers = std::array<double, shown_names.size()>;

/// For each state of the model, its index in shown_names.
std::vector<std::size_t> shown_by(const Model& model) {
  std::vector<std::size_t> all;
  for (const std::string_view state : model.states()) {
    const auto found = std::find(shown_names.begin(), shown_names.end(), state);
    if (found == shown_names.end())
      throw_invalid("the state {} of {} is none that a vehicle shows", state, model.name());
    all.push_back(static_cast<std::size_t>(found - shown_names.begin()));
  }
  return all;
}

ShownNumbers shown_of(const RigidBody& body) {
  const Rotation R = rotation(body.q);
  const Vec2<double> d = heading(R), v = rotate<double>({d.x, -d.y}, {body.v.x, body.v.y});
  const double lean = gravity / std::max(R.z.z, 0.1);  // bounded for every attitude
  const Vec2<double> a = rotate<double>({d.x, -d.y}, {lean * R.z.x, lean * R.z.y});
  return {body.p.x, body.p.y, body.p.z, d.x,      d.y,      atan2(d.y, d.x),
          v.x,      v.y,      body.v.x, body.v.y, body.v.z, heading_rate(R, body.w),
          a.x,      a.y};
}

/// Index of the first number that a vehicle with an IMU measures itself.
constexpr std::size_t first_sensed = 11;
static_assert(shown_names[first_sensed] == "r");

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
    int& craft = craft_of_[at(one.robot)];
    if (craft >= 0) throw_invalid("{} is two vehicles, expected one", team.name(one.robot));
    craft = static_cast<int>(crafts_.size());
    crafts_.push_back({.robot = one.robot,
                       .flown = Rotorcraft(one.vehicle, *commands, plant.seed, one.robot.index),
                       .shown = shown_by(model),
                       .inputs = model.nu()});
  }
}

const Rotorcraft* Fleet::rotorcraft(BodyId robot) const noexcept {
  if (robot.index < 0 || at(robot) >= craft_of_.size() || craft_of_[at(robot)] < 0) return nullptr;
  return &crafts_[size(craft_of_[at(robot)])].flown;
}

void Fleet::begin(BodyId robot, double, const double* x) noexcept {
  Craft& craft = crafts_[size(craft_of_[at(robot)])];
  ShownNumbers n{};
  for (std::size_t i = 0; i < craft.shown.size(); ++i) n[craft.shown[i]] = x[i];
  const auto [p_x, p_y, p_z, d_x, d_y, psi, v_f, v_s, v_x, v_y, v_z, r, a_f, a_s] = n;
  const bool has_angle = d_x == 0 && d_y == 0;
  const Vec2<double> d = has_angle ? Vec2<double>{cos(psi), sin(psi)} : Vec2<double>{d_x, d_y};
  const Vec2<double> v = rotate<double>(d, {v_f, v_s});
  craft.flown.begin({p_x, p_y, p_z}, d, {v.x + v_x, v.y + v_y, v_z}, r);
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
                .radius2 = static_cast<double>(v.rotors()) * square(v.rotor_radius)};
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
  const ShownNumbers n = shown_of(craft.flown.body());
  for (std::size_t i = 0; i < craft.shown.size(); ++i) x[i] = n[craft.shown[i]];
}

void Fleet::sense(BodyId robot, double* x) const noexcept {
  const Craft& craft = crafts_[size(craft_of_[at(robot)])];
  if (!craft.flown.vehicle().imu) return;
  const ShownNumbers n = shown_of(craft.flown.seen());
  for (std::size_t i = 0; i < craft.shown.size(); ++i) {
    if (craft.shown[i] >= first_sensed) x[i] = n[craft.shown[i]];
  }
}

}  // namespace sightline
