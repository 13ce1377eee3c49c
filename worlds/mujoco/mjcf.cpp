#include "worlds/mujoco/mjcf.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <string_view>

#include "sightline/base.hpp"
#include "sightline/report/page.hpp"
#include "sightline/world.hpp"
#include "sightline/world/rotorcraft.hpp"

namespace sightline::mujoco {
namespace {

std::string include(const ModelFile& file) {
  const std::string name = std::filesystem::path(file.name).filename().string();
  return fmt::format("<include file=\"{}\"/>\n", escaped(name));
}

/// The name attribute of a body; empty for MuJoCo's reserved word "world".
std::string name_of(std::string_view name) {
  return name == "world" ? "" : fmt::format(" name=\"{}\"", escaped(name));
}

constexpr std::array<std::string_view, 8> type_words = {"plane",     "hfield",   "sphere", "capsule",
                                                        "ellipsoid", "cylinder", "box",    "mesh"};

/// All attributes of a geom, since the defaults of a file could change any that is omitted.
std::string attributes(std::string_view type, int contype, int conaffinity, double gap) {
  return fmt::format(
      "type=\"{}\" contype=\"{}\" conaffinity=\"{}\" gap=\"{}\" margin=\"0\" condim=\"3\" mass=\"0\" "
      "friction=\"1 0.005 0.0001\" solref=\"0.02 1\" solimp=\"0.9 0.95 0.001 0.5 2\" solmix=\"1\" "
      "priority=\"0\"",
      type, contype, conaffinity, gap);
}

/// Writes vehicles, and the meshes of their geoms.
class Writer {
 public:
  std::string vehicle(std::string_view name, const Vehicle& v, const Geoms& geoms) {
    constexpr double beyond_any_depth = 1e6;  // [m]
    std::string text =
        fmt::format("<body{}><freejoint/><inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"{} {} {}\"/>\n",
                    name_of(name), v.mass, v.inertia.x, v.inertia.y, v.inertia.z);
    for (const Geom& one : geoms.outer) text += geom(one, outer_bit, outer_bit, beyond_any_depth);
    for (const Geom& one : geoms.solid) text += geom(one, solid_bits, 0, 0.0);
    return text + "</body>\n";
  }
  const std::string& meshes() const { return meshes_; }

 private:
  std::string geom(const Geom& g, int contype, int conaffinity, double gap) {
    const bool mesh = g.type == mjGEOM_MESH;
    std::string of = fmt::format("size=\"{}\"", fmt::join(g.size, " "));
    if (mesh) {
      of = fmt::format("mesh=\"mesh {} of a vehicle\"", count_);
      meshes_ += fmt::format("<mesh name=\"mesh {} of a vehicle\" scale=\"1 1 1\" vertex=\"{}\"/>\n",
                             count_++, fmt::join(g.vertices, " "));
    }
    return fmt::format("<geom {} {} pos=\"{}\" quat=\"{}\"/>\n",
                       attributes(type_words[size(g.type)], contype, conaffinity, gap), of,
                       fmt::join(g.p, " "), fmt::join(g.q, " "));
  }

  std::string meshes_;
  int count_ = 0;
};

std::string point(std::string_view name) {
  return fmt::format("<body{} mocap=\"true\"><geom {} size=\"1e-4\"/></body>\n", name_of(name),
                     attributes("sphere", 0, outer_bit, 0.0));
}

}  // namespace

std::string included(const ModelFile& file) { return "<mujoco>\n" + include(file) + "</mujoco>\n"; }

std::string mjcf_of(const Team& team, const std::vector<RobotVehicle>& vehicles,
                    const std::vector<Geoms>& geoms, const std::optional<ModelFile>& surroundings) {
  Writer write;
  std::string bodies;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    const auto found =
        std::find_if(vehicles.begin(), vehicles.end(), [&](const auto& one) { return one.robot == body; });
    bodies += found == vehicles.end()
                  ? point(team.name(body))
                  : write.vehicle(team.name(body), found->vehicle,
                                  geoms[static_cast<std::size_t>(found - vehicles.begin())]);
  }
  // The buffer holds the contacts of all vehicles on the ground at once; a file may request more.
  // The options after the file override its own.
  std::string text = fmt::format("<mujoco>\n<size nconmax=\"{}\" njmax=\"{}\"/>\n", 100 + 8 * vehicles.size(),
                                 500 + 20 * vehicles.size());
  if (surroundings) text += include(*surroundings);
  text += fmt::format(
      "<compiler inertiafromgeom=\"auto\" balanceinertia=\"false\" boundmass=\"0\" boundinertia=\"0\" "
      "settotalmass=\"-1\"/>\n"
      "<option timestep=\"{}\" integrator=\"Euler\" gravity=\"0 0 {}\" wind=\"0 0 0\" density=\"0\" "
      "viscosity=\"0\"><flag constraint=\"enable\" contact=\"enable\" gravity=\"enable\" passive=\"enable\" "
      "override=\"disable\"/></option>\n",
      rotorcraft_step, -gravity);
  if (!write.meshes().empty()) text += "<asset>\n" + write.meshes() + "</asset>\n";
  text += fmt::format("<worldbody>\n<geom name=\"{}\" {} size=\"0 0 1\" pos=\"0 0 0\" quat=\"1 0 0 0\"/>\n",
                      ground, attributes("plane", 1, 1, 0.0));
  return text + bodies + "</worldbody>\n</mujoco>\n";
}

}  // namespace sightline::mujoco
