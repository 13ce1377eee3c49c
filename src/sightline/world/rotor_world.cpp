#include "sightline/world/rotor_world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "sightline/base/index.hpp"
#include "sightline/base/refuse.hpp"

namespace sightline {
namespace {

/// What the states of planning models show of a vehicle.
constexpr std::array<std::string_view, 12> shown_names = {"p_x", "p_y", "p_z", "d_x", "d_y", "psi",
                                                          "v_f", "v_s", "v_z", "r",   "a_f", "a_s"};
using ShownNumbers = std::array<double, shown_names.size()>;

/// Of each state of the model, which of them it is.
std::vector<std::size_t> shown_by(const Model& model) {
  std::vector<std::size_t> all;
  for (const std::string_view state : model.states()) {
    const auto found = std::find(shown_names.begin(), shown_names.end(), state);
    if (found == shown_names.end())
      refuse("the state {} of {} is none that a vehicle shows", state, model.name());
    all.push_back(static_cast<std::size_t>(found - shown_names.begin()));
  }
  return all;
}

void check_period(double period) {
  const double steps = period / rotorcraft_step;
  if (std::abs(steps - std::round(steps)) > 1e-6 || std::round(steps) < 1)
    refuse(
        "world.kind = \"rotors\" moves in steps of {} s, but the period is {} s, expected a whole number of "
        "steps",
        rotorcraft_step, period);
}

/// Refuses wind that finds no drag to push.
void check_wind(const Vehicle& vehicle, std::string_view name, const Disturbances& d) {
  const Vec3<double> drag = vehicle.hover_drag();
  const bool everywhere = d.gust_sigma > 0, level = everywhere || d.airflow.amplitude > 0;
  const bool calm = (drag.x > 0 || !(level || d.wind.x != 0 || d.wind.y != 0)) &&
                    (drag.z > 0 || !(everywhere || d.wind.z != 0));
  if (!calm)
    refuse("vehicle.drag of {} is [{}, {}, {}] N s/m, expected one that wind, gusts and wakes can push", name,
           vehicle.drag.x, vehicle.drag.y, vehicle.drag.z);
}

}  // namespace

/// The vehicles as the plant's dynamics.
class RotorWorld::Fleet final : public RobotDynamics {
 public:
  Fleet(const Team& team, const std::vector<RobotVehicle>& vehicles) : crafts_(size(team.bodies())) {
    for (const RobotVehicle& one : vehicles) {
      if (one.robot.index < 0 || one.robot.index >= team.bodies() || !team.is_agent(one.robot))
        refuse("a vehicle is of body {}, expected a robot of the team", one.robot.index);
      const Model& model = team.model(one.robot);
      const std::optional<Commands> commands = commands_of(model);
      if (!commands)
        refuse("{} is of the kind {}, expected one that a vehicle can be: {}", team.name(one.robot),
               model.name(), robots_with_vehicles());
      std::optional<Craft>& craft = crafts_[at(one.robot)];
      if (craft) refuse("{} is two vehicles, expected one", team.name(one.robot));
      craft.emplace(Craft{Rotorcraft(one.vehicle, *commands), shown_by(model)});
    }
  }

  bool moves(BodyId robot) const noexcept override { return crafts_[at(robot)].has_value(); }

  void begin(BodyId robot, double t, const double* x) noexcept override {
    Craft& craft = *crafts_[at(robot)];
    ShownNumbers n{};
    for (std::size_t i = 0; i < craft.shown.size(); ++i) n[craft.shown[i]] = x[i];
    const auto [p_x, p_y, p_z, d_x, d_y, psi, v_f, v_s, v_z, r, a_f, a_s] = n;
    const bool has_angle = d_x == 0 && d_y == 0;
    const Vec2<double> d = has_angle ? Vec2<double>{cos(psi), sin(psi)} : Vec2<double>{d_x, d_y};
    const Vec2<double> v = rotate<double>(d, {v_f, v_s});
    craft.flown.begin({p_x, p_y, p_z}, d, {v.x, v.y, v_z}, r);
    craft.tick = tick_of(t);
  }

  void move(BodyId robot, double t, const double* u, const Vec3<double>& acceleration,
            double* x) noexcept override {
    Craft& craft = *crafts_[at(robot)];
    const std::array<double, 4> commands = {u[0], u[1], u[2], u[3]};
    const Vec3<double> air = craft.flown.vehicle().air(acceleration);
    for (const std::int64_t until = tick_of(t); craft.tick < until; ++craft.tick)
      craft.flown.step(commands, air);
    show(craft, x);
  }

  const Rotorcraft* rotorcraft(BodyId robot) const noexcept {
    const bool there = robot.index >= 0 && at(robot) < crafts_.size() && crafts_[at(robot)];
    return there ? &crafts_[at(robot)]->flown : nullptr;
  }

 private:
  struct Craft {
    Rotorcraft flown;
    std::vector<std::size_t> shown;  // by each state
    std::int64_t tick = 0;           // steps since the start of the world
  };

  static std::int64_t tick_of(double t) noexcept { return std::llround(t / rotorcraft_step); }

  static void show(const Craft& craft, double* x) noexcept {
    const RigidBody& body = craft.flown.body();
    const Vec2<double> d = craft.flown.heading(), v = rotate<double>({d.x, -d.y}, {body.v.x, body.v.y});
    const Vec3<double> thrust = craft.flown.attitude().z;
    const double lean = gravity / std::max(thrust.z, 0.1);  // finite, however it tumbles
    const Vec2<double> a = rotate<double>({d.x, -d.y}, {lean * thrust.x, lean * thrust.y});
    const ShownNumbers n = {body.p.x, body.p.y,
                            body.p.z, d.x,
                            d.y,      atan2(d.y, d.x),
                            v.x,      v.y,
                            body.v.z, craft.flown.heading_rate(),
                            a.x,      a.y};
    for (std::size_t i = 0; i < craft.shown.size(); ++i) x[i] = n[craft.shown[i]];
  }

  std::vector<std::optional<Craft>> crafts_;
};

RotorWorld::RotorWorld(Team team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
                       PlantOptions plant, const SensorOptions& sensor)
    : fleet_(std::make_unique<Fleet>(team, vehicles)) {
  check_period(plant.period);
  plant.dynamics = fleet_.get();
  world_ = std::make_unique<ModelWorld>(std::move(team), std::move(x0), plant, sensor);
  const Team& all = world_->team();
  presence_.resize(size(all.bodies()), Presence::steered);
  rest_.resize(size(all.nu()));
  for (const RobotVehicle& one : vehicles) {
    check_wind(one.vehicle, all.name(one.robot), plant.disturbances);
    if (const double z = position(one.robot).z; z < 0)
      refuse("{} starts at a height of {} m, expected one above the ground, at least 0 m",
             all.name(one.robot), z);
    for (int i = 0; i < all.bodies(); ++i) {
      const BodyId other{i};
      const Rotorcraft* const craft = fleet_->rotorcraft(other);
      if (other == one.robot || (craft != nullptr && i < one.robot.index)) continue;
      const double radius = craft != nullptr ? craft->vehicle().radius : 0.0;
      const double height = craft != nullptr ? craft->vehicle().height : 0.0;
      pairs_.push_back({one.robot, other, one.vehicle.radius + radius, 0.5 * (one.vehicle.height + height)});
    }
  }
}

RotorWorld::~RotorWorld() = default;

void RotorWorld::set_presence(std::span<const Presence> presence) noexcept {
  world_->set_presence(presence);
  for (std::size_t i = 0; i < std::min(presence.size(), presence_.size()); ++i) {
    const Presence was = std::exchange(presence_[i], presence[i]);
    if (was != Presence::absent || presence[i] == Presence::absent) continue;
    for (Pair& pair : pairs_) {
      if (at(pair.a) == i || at(pair.b) == i) pair.apart = false;
    }
  }
}

bool RotorWorld::apply(double t, std::span<const double> believed, std::span<const double> u, double period,
                       std::int64_t periods) noexcept {
  for (std::int64_t k = 0; k < periods; ++k) {
    if (!world_->apply(t + static_cast<double>(k) * period, believed, u, period, 1)) return false;
    touch_ = touch(t + static_cast<double>(k + 1) * period);
    if (touch_) return false;
  }
  return true;
}

Vec3<double> RotorWorld::position(BodyId body) const noexcept {
  if (const Rotorcraft* const craft = fleet_->rotorcraft(body)) return craft->body().p;
  const Team& all = world_->team();
  const double* const x = &world_->x()[size(all.state_offset(body))];
  return all.model(body).sight(x, rest_.data()).p;  // no pose depends on inputs
}

/// The first touch that there is at t.
std::optional<RotorWorld::Touch> RotorWorld::touch(double t) noexcept {
  const auto there = [&](BodyId body) { return presence_[at(body)] != Presence::absent; };
  for (int i = 0; i < world_->team().bodies(); ++i) {
    const Rotorcraft* const craft = fleet_->rotorcraft(BodyId{i});
    if (craft != nullptr && there(BodyId{i}) && craft->crash_speed() > 0)
      return Touch{BodyId{i}, BodyId{-1}, t, craft->crash_speed()};
  }
  for (Pair& pair : pairs_) {
    if (!there(pair.a) || !there(pair.b)) continue;
    const Vec3<double> r = position(pair.a) - position(pair.b);
    const bool touches = norm(r.x, r.y) < pair.radii && std::abs(r.z) < pair.height;
    if (touches && pair.apart) return Touch{pair.a, pair.b, t, 0.0};
    pair.apart = pair.apart || !touches;
  }
  return std::nullopt;
}

std::string RotorWorld::ended() const {
  if (!touch_) return {};
  const Team& all = world_->team();
  if (touch_->b.index < 0) {
    return fmt::format("{} touched the ground at {:.3f} s with {:.2f} m/s, expected at most {} m/s",
                       all.name(touch_->a), touch_->t, touch_->speed, landing_speed_max);
  }
  return fmt::format("{} and {} touched at {:.3f} s", all.name(touch_->a), all.name(touch_->b), touch_->t);
}

const Rotorcraft* RotorWorld::rotorcraft(BodyId robot) const { return fleet_->rotorcraft(robot); }

}  // namespace sightline
