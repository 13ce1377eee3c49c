#include "worlds/mujoco/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "worlds/mujoco/mjcf.hpp"
#include "worlds/mujoco/shape.hpp"

namespace sightline {
namespace {

using namespace mujoco;

constexpr double depth_at_start_max = 1e-3;  // [m]
constexpr std::size_t overlaps_per_body = 8;

ModelPointer model_of(const Team& team, const std::vector<RobotVehicle>& vehicles,
                      const std::optional<ModelFile>& surroundings) {
  std::vector<Geoms> geoms;
  for (const RobotVehicle& one : vehicles) {
    Geoms& its = geoms.emplace_back();
    if (one.model) its.outer = its.solid = shape_of(*one.model).geoms;
    if (its.outer.empty()) its = {{hull_of(one.vehicle)}, {foot_of(one.vehicle)}};
  }
  const std::string mjcf = mjcf_of(team, vehicles, geoms, surroundings);
  try {
    return load(mjcf, surroundings ? &*surroundings : nullptr);
  } catch (const std::invalid_argument& error) {
    if (!surroundings) throw_invalid("MuJoCo refuses the model of the team: {}", error.what());
    throw_invalid("model = \"{}\", MuJoCo refuses it: {}", surroundings->name, error.what());
  }
}

}  // namespace

MujocoWorld::Bodies::Bodies(const Team& team, const std::vector<RobotVehicle>& vehicles,
                            const PlantOptions& plant, const std::optional<ModelFile>& surroundings)
    : Fleet(team, vehicles, plant),
      model_(model_of(team, vehicles, surroundings)),
      data_(data_of(*model_)),
      bodies_(size(team.bodies())),
      owner_(size(model_->ngeom), -1) {
  overlaps_.reserve(overlaps_per_body * bodies_.size());
  for (int i = 0; i < model_->ngeom; ++i)
    bits_.emplace_back(model_->geom_contype[i], model_->geom_conaffinity[i]);
  for (int i = 0; i < team.bodies(); ++i) {
    Body& body = bodies_[size(i)];
    body.id = model_->nbody - team.bodies() + i;
    body.mocap = model_->body_mocapid[body.id];
    for (int k = 0; k < model_->body_geomnum[body.id]; ++k)
      owner_[size(model_->body_geomadr[body.id] + k)] = i;
    if (body.mocap >= 0) continue;
    const int joint = model_->body_jntadr[body.id];
    body.q = model_->jnt_qposadr[joint];
    body.dof = model_->jnt_dofadr[joint];
    const Vehicle& v = rotorcraft(BodyId{i})->vehicle();
    const double *const mass = model_->body_mass + body.id, *const inertia =
                                                                model_->body_inertia + 3 * body.id;
    if (*mass != v.mass || inertia[0] != v.inertia.x || inertia[1] != v.inertia.y ||
        inertia[2] != v.inertia.z)
      throw_invalid("model = \"{}\", its settings change the mass or the inertia of {}",
                    surroundings ? surroundings->name : "", team.name(BodyId{i}));
  }
}

void MujocoWorld::Bodies::begin(BodyId robot, double t, const double* x) noexcept {
  Fleet::begin(robot, t, x);
  for (const Craft& craft : crafts_) {
    if (craft.robot == robot) write(craft);
  }
}

void MujocoWorld::Bodies::place(BodyId body, const Vec3<double>& p, const Vec3<double>& v) noexcept {
  bodies_[at(body)].p = p;
  bodies_[at(body)].v = v;
  placed_at_ = tick();
  double* const to = data_->mocap_pos + 3 * bodies_[at(body)].mocap;
  to[0] = p.x, to[1] = p.y, to[2] = p.z;
}

void MujocoWorld::Bodies::set_there(BodyId body, bool there) noexcept {
  Body& one = bodies_[at(body)];
  one.fresh = there;
  const int first = model_->body_geomadr[one.id];
  for (int geom = first; geom < first + model_->body_geomnum[one.id]; ++geom) {
    const auto [contype, conaffinity] = bits_[size(geom)];
    model_->geom_contype[geom] = there ? contype : 0;
    model_->geom_conaffinity[geom] = there ? conaffinity : 0;
  }
}

void MujocoWorld::Bodies::write(const Craft& craft) noexcept {
  const Body& body = bodies_[at(craft.robot)];
  const RigidBody& b = craft.flown.body();
  const std::array q = {b.p.x, b.p.y, b.p.z, b.q.w, b.q.x, b.q.y, b.q.z};
  const std::array v = {b.v.x, b.v.y, b.v.z, b.w.x, b.w.y, b.w.z};  // linear in G, angular in B
  std::copy(q.begin(), q.end(), data_->qpos + body.q);
  std::copy(v.begin(), v.end(), data_->qvel + body.dof);
}

void MujocoWorld::Bodies::read(Craft& craft) noexcept {
  const Body& body = bodies_[at(craft.robot)];
  const double *const q = data_->qpos + body.q, *const v = data_->qvel + body.dof;
  craft.flown.moved_to({q[0], q[1], q[2]}, {q[3], q[4], q[5], q[6]}, {v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

void MujocoWorld::Bodies::advance(std::int64_t steps) noexcept {
  for (std::int64_t k = 0; k < steps && !met_ && !failed_; ++k) {
    const double since = static_cast<double>(tick() + k - placed_at_) * rotorcraft_step;
    for (const Body& body : bodies_) {
      if (body.mocap < 0) continue;
      const Vec3<double> p = body.p + since * body.v;
      double* const to = data_->mocap_pos + 3 * body.mocap;
      to[0] = p.x, to[1] = p.y, to[2] = p.z;
    }
    if (!step_1(*model_, *data_)) return fail(last_error(), tick() + k);
    look_at_contacts(tick() + k);
    if (met_) return;
    for (Craft& craft : crafts_) {
      if (!craft.steered) continue;
      const Wrench wrench = craft.flown.push(craft.commands, craft.air);
      const std::array force = {wrench.force.x,  wrench.force.y,  wrench.force.z,
                                wrench.torque.x, wrench.torque.y, wrench.torque.z};
      std::copy(force.begin(), force.end(), data_->qfrc_applied + bodies_[at(craft.robot)].dof);
    }
    if (!step_2(*model_, *data_)) return fail(last_error(), tick() + k);
    if (const char* const why = warning(*data_)) return fail(why, tick() + k);
    for (Craft& craft : crafts_) {
      if (craft.steered) {
        read(craft);
      } else {
        write(craft);
      }
    }
  }
}

/// Records the first contact that is a touch. Contacts are those at the beginning of the step;
/// velocities are those before the contact forces.
void MujocoWorld::Bodies::look_at_contacts(std::int64_t tick) noexcept {
  for (int i = 0; i < data_->ncon && !met_; ++i) {
    const mjContact& contact = data_->contact[i];
    const int a = owner_[size(contact.geom1)], b = owner_[size(contact.geom2)];
    if (a >= 0 && b >= 0) {
      if (!(contact.dist < 0) || excused(std::min(a, b), std::max(a, b))) continue;
      const int vehicle = bodies_[size(a)].mocap < 0 ? a : b;
      met_ = Met{.a = BodyId{vehicle}, .b = BodyId{vehicle == a ? b : a}, .tick = tick};
      continue;
    }
    const int vehicle = std::max(a, b);
    const int other = a >= 0 ? contact.geom2 : contact.geom1;
    if (vehicle < 0 || bits_[size(a >= 0 ? contact.geom1 : contact.geom2)].second == outer_bit) continue;
    if (contact.exclude != 0) continue;  // contact without force
    const double speed = norm(rotorcraft(BodyId{vehicle})->body().v);
    if (speed > landing_speed_max)
      met_ =
          Met{.a = BodyId{vehicle}, .b = BodyId{-1}, .tick = tick, .speed = speed, .surface = surface(other)};
  }
  std::erase_if(overlaps_, [](const Overlap& pair) { return !pair.seen; });
  for (Overlap& pair : overlaps_) pair.seen = false;
  for (Body& body : bodies_) body.fresh = false;
}

/// Whether the two bodies have overlapped since one of them joined.
bool MujocoWorld::Bodies::excused(int a, int b) noexcept {
  for (Overlap& pair : overlaps_) {
    if (pair.a == a && pair.b == b) return pair.seen = true;
  }
  if (!(bodies_[size(a)].fresh || bodies_[size(b)].fresh) || overlaps_.size() == overlaps_.capacity())
    return false;
  overlaps_.push_back({a, b, true});
  return true;
}

void MujocoWorld::Bodies::fail(const char* why, std::int64_t tick) noexcept {
  failed_ = true;
  failed_at_ = tick;
  std::string_view(why).copy(failure_.data(), failure_.size() - 1);
}

std::string MujocoWorld::Bodies::failure() const {
  return fmt::format("MuJoCo ended it at {:.3f} s: {}", static_cast<double>(failed_at_) * rotorcraft_step,
                     on_one_line(failure_.data()));
}

std::string_view MujocoWorld::Bodies::surface(int geom) const noexcept {
  for (const char* const name : {mj_id2name(model_.get(), mjOBJ_GEOM, geom),
                                 mj_id2name(model_.get(), mjOBJ_BODY, model_->geom_bodyid[geom])}) {
    if (name != nullptr && *name != '\0' && std::string_view(name) != "world") return name;
  }
  return "a geom of the model";
}

void MujocoWorld::Bodies::check_start(const Team& team) {
  if (!find_contacts(*model_, *data_))
    throw_invalid("MuJoCo finds no contacts: {}", on_one_line(last_error()));
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    const int a = owner_[size(contact.geom1)], b = owner_[size(contact.geom2)];
    if ((a >= 0) == (b >= 0) || contact.dist > -depth_at_start_max) continue;
    const int own = a >= 0 ? contact.geom1 : contact.geom2, other = a >= 0 ? contact.geom2 : contact.geom1;
    if (bits_[size(own)].second == outer_bit) continue;
    throw_invalid("{} starts {:.3g} m deep in {}, expected outside of it", team.name(BodyId{std::max(a, b)}),
                  -contact.dist, surface(other));
  }
}

}  // namespace sightline
