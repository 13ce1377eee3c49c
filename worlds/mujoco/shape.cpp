#include "worlds/mujoco/shape.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "worlds/mujoco/engine.hpp"
#include "worlds/mujoco/mjcf.hpp"

namespace sightline::mujoco {
namespace {

constexpr double off_axis_max = 0.01;  // fraction of the least moment of inertia

std::vector<std::string> names_of_bodies(const mjModel& model) {
  std::vector<std::string> all;
  for (int i = 1; i < model.nbody; ++i) {
    const char* const name = mj_id2name(&model, mjOBJ_BODY, i);
    if (name != nullptr && *name != '\0') all.push_back(fmt::format("\"{}\"", name));
  }
  return all;
}

/// Whether `part` is `body` or one of its descendants.
bool belongs(const mjModel& model, int part, int body) {
  while (part > body) part = model.body_parentid[part];
  return part == body;
}

/// Rotates a vector from G into the axes of the body.
std::array<double, 3> turned(const mjData& data, int body, const std::array<double, 3>& a_G) {
  std::array<double, 3> a{};
  mju_rotVecMatT(a.data(), a_G.data(), data.xmat + 9 * body);
  return a;
}

/// Adds the inertia of one part about the centre of mass of the whole, in the axes of the body.
void add_inertia(const mjModel& model, const mjData& data, int part, int body, std::array<double, 9>& sum) {
  const double* const com = data.subtree_com + 3 * body;
  const std::array<double, 3> r = turned(
      data, body,
      {data.xipos[3 * part] - com[0], data.xipos[3 * part + 1] - com[1], data.xipos[3 * part + 2] - com[2]});
  std::array<double, 9> axes{};
  mju_mulMatTMat(axes.data(), data.xmat + 9 * body, data.ximat + 9 * part, 3, 3, 3);
  const double mass = model.body_mass[part], square_of_r = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double about_part = 0.0;
      for (std::size_t k = 0; k < 3; ++k)
        about_part += axes[3 * i + k] * model.body_inertia[3 * size(part) + k] * axes[3 * j + k];
      sum[3 * i + j] += about_part + mass * ((i == j ? square_of_r : 0.0) - r[i] * r[j]);
    }
  }
}

Geom geom_of(const mjModel& model, const mjData& data, int geom, int body) {
  const double *const com = data.subtree_com + 3 * body, *const p = data.geom_xpos + 3 * geom;
  Geom made{.type = model.geom_type[geom]};
  std::copy_n(model.geom_size + 3 * geom, 3, made.size.begin());
  made.p = turned(data, body, {p[0] - com[0], p[1] - com[1], p[2] - com[2]});
  std::array<double, 9> axes{};
  mju_mulMatTMat(axes.data(), data.xmat + 9 * body, data.geom_xmat + 9 * geom, 3, 3, 3);
  mju_mat2Quat(made.q.data(), axes.data());
  if (made.type == mjGEOM_MESH) {
    const int mesh = model.geom_dataid[geom];
    const float* const first = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
    made.vertices.assign(first, first + 3 * model.mesh_vertnum[mesh]);
  }
  return made;
}

}  // namespace

Shape shape_of(const ModelBody& model) {
  const ModelFile& file = model.file;
  ModelPointer read;
  try {
    read = load(included(file), &file);
  } catch (const std::invalid_argument& error) {
    throw_invalid("model = \"{}\", MuJoCo refuses it: {}", file.name, error.what());
  }
  const auto names = names_of_bodies(*read);
  if (names.empty()) throw_invalid("model = \"{}\", expected an MJCF with a body that has a name", file.name);
  const int body = mj_name2id(read.get(), mjOBJ_BODY, model.body.c_str());
  if (body <= 0)
    throw_invalid("body = \"{}\", expected one of {}: {}", model.body, file.name, fmt::join(names, ", "));

  const DataPointer data = data_of(*read);
  mj_kinematics(read.get(), data.get());
  mj_comPos(read.get(), data.get());
  Shape shape;
  std::array<double, 9> inertia{};
  for (int part = body; part < read->nbody; ++part) {
    if (!belongs(*read, part, body)) continue;
    shape.mass += read->body_mass[part];
    add_inertia(*read, *data, part, body, inertia);
  }
  if (!(shape.mass > 0)) throw_invalid("body = \"{}\", expected one with mass, it has none", model.body);
  shape.inertia = {inertia[0], inertia[4], inertia[8]};
  const double off = std::max({std::abs(inertia[1]), std::abs(inertia[2]), std::abs(inertia[5])});
  if (off > off_axis_max * std::min({inertia[0], inertia[4], inertia[8]}))
    throw_invalid(
        "body = \"{}\", expected principal axes of inertia along its x, y and z, a product of inertia is "
        "{:.3g} "
        "kg m^2",
        model.body, off);

  for (int geom = 0; geom < read->ngeom; ++geom) {
    const bool touches = read->geom_contype[geom] != 0 || read->geom_conaffinity[geom] != 0;
    if (!touches || !belongs(*read, read->geom_bodyid[geom], body)) continue;
    const int type = read->geom_type[geom];
    if (type == mjGEOM_PLANE || type == mjGEOM_HFIELD)
      throw_invalid("body = \"{}\", expected one without planes and height fields that touch", model.body);
    shape.geoms.push_back(geom_of(*read, *data, geom, body));
  }
  return shape;
}

Geom hull_of(const Vehicle& vehicle) {
  return {.type = mjGEOM_CYLINDER, .size = {vehicle.radius, 0.5 * vehicle.height, 0.0}};
}

Geom foot_of(const Vehicle& vehicle) {
  return {.type = mjGEOM_CYLINDER,
          .size = {vehicle.radius, 0.25 * vehicle.height, 0.0},
          .p = {0.0, 0.0, 0.25 * vehicle.height}};
}

}  // namespace sightline::mujoco
