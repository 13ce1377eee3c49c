#include "sightline/import/vehicle_description.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "sightline/import/kinds.hpp"
#include "sightline/vehicle.hpp"

namespace sightline {
namespace {

/// All parts as one rigid body.
RigidPart together(const std::vector<RigidPart>& all) {
  RigidPart sum;
  for (const RigidPart& one : all) sum.m += one.m, sum.p = sum.p + one.m * one.p;
  sum.p = (1 / sum.m) * sum.p;
  for (const RigidPart& one : all) {
    const Mat<3, 3> K = cross_matrix(one.p - sum.p);
    sum.I += one.I + one.m * (K * transposed(K));
  }
  return sum;
}

/// Sets what all motors have in common. @return false if another motor has another number
bool same(std::optional<double>& all, double one) {
  const double first = all.value_or(one);
  all = first;
  return first == one;
}

/// Lines `key = number`, and the keys of numbers that are missing.
class VehicleLines {
 public:
  void add(std::string_view key, const std::optional<double>& value) {
    if (value) {
      text += fmt::format("{} = {}\n", key, toml_number(*value));
    } else {
      missing.push_back(key);
    }
  }
  void add(std::string_view key, std::span<const double> values) {
    text += fmt::format("{} = {}\n", key, toml_numbers(values));
  }

  std::string text{};
  std::vector<std::string_view> missing{};
};

}  // namespace

void add_motor(VehicleDescription& to, const XmlFile& file, const XmlFile::Element& plugin,
               const std::map<std::string, PartPose>& links,
               const std::map<std::string, std::string>& joints) {
  const bool by_link = plugin.FirstChildElement("linkName") != nullptr;
  std::string link = file.word(plugin, by_link ? "linkName" : "jointName", "the link of its rotor");
  if (const auto joint = joints.find(link); !by_link && joint != joints.end()) link = joint->second;
  const auto place = links.find(link);
  if (place == links.end()) file.refuse(plugin, link, "a link of these files: give the file that has it too");
  if (!(place->second.R(2, 2) > 0.999))
    file.refuse(plugin, link, "a rotor that thrusts along z of its model");
  const std::string turns = file.word(plugin, "turningDirection", "cw or ccw");
  if (turns != "cw" && turns != "ccw")
    file.refuse(*plugin.FirstChildElement("turningDirection"), turns, "cw or ccw");
  const Range lag = {0.004, 1, "0.004 to 1 s"};
  const bool as_first =
      same(to.k_f, file.number(plugin, "motorConstant", positive("> 0 N s^2"))) &&
      same(to.k_m, file.number(plugin, "momentConstant", positive("> 0 m"))) &&
      same(to.speed_max, file.number(plugin, "maxRotVelocity", positive("> 0 rad/s"))) &&
      same(to.tau_up, file.number(plugin, "timeConstantUp", lag)) &&
      same(to.tau_down, file.number(plugin, "timeConstantDown", lag)) &&
      same(to.rotor_drag, file.number(plugin, "rotorDragCoefficient", not_negative(">= 0 N s^2/m"), 0.0));
  if (!as_first) file.refuse(plugin, link, "the constants of the first motor");
  to.rotors.push_back({place->second.p, turns == "ccw" ? 1.0 : -1.0});
  if (to.rotors.size() > described_parts_max)
    file.refuse(plugin, "one of many", fmt::format("at most {} motors", described_parts_max));
}

Imported vehicle_table(const VehicleDescription& found, const XmlFile& file, const ImportOptions& options) {
  const RigidPart body = together(found.parts);
  if (!(body.m > 0)) file.refuse(file.root(), "no mass", "parts with masses > 0 kg");
  Vehicle vehicle;
  vehicle.mass = body.m;
  vehicle.inertia = {body.I(0, 0), body.I(1, 1), body.I(2, 2)};
  vehicle.rotor_x.clear(), vehicle.rotor_y.clear(), vehicle.spin.clear();
  for (const DescribedRotor& one : found.rotors) {
    vehicle.rotor_x.push_back(one.p.x - body.p.x);
    vehicle.rotor_y.push_back(one.p.y - body.p.y);
    vehicle.spin.push_back(one.spin);
  }
  const bool spins =
      std::all_of(vehicle.spin.begin(), vehicle.spin.end(), [](double spin) { return spin != 0; });
  const std::array<double, 3> inertia = {vehicle.inertia.x, vehicle.inertia.y, vehicle.inertia.z};

  VehicleLines lines;
  lines.add("mass", vehicle.mass);
  lines.add("inertia", inertia);
  if (found.rotors.empty()) {
    lines.missing = {"rotor_x", "rotor_y", "spin"};
  } else {
    lines.add("rotor_x", vehicle.rotor_x);
    lines.add("rotor_y", vehicle.rotor_y);
    if (spins) {
      lines.add("spin", vehicle.spin);
    } else {
      lines.text += "spin = []  # not in the file: 1 anticlockwise, -1 clockwise, for each rotor above\n";
    }
  }
  const std::array<std::pair<std::string_view, std::pair<double Vehicle::*, const std::optional<double>*>>, 9>
      numbers = {{{"k_f", {&Vehicle::k_f, &found.k_f}},
                  {"k_m", {&Vehicle::k_m, &found.k_m}},
                  {"speed_max", {&Vehicle::speed_max, &found.speed_max}},
                  {"tau_up", {&Vehicle::tau_up, &found.tau_up}},
                  {"tau_down", {&Vehicle::tau_down, &found.tau_down}},
                  {"rotor_drag", {&Vehicle::rotor_drag, &found.rotor_drag}},
                  {"rotor_radius", {&Vehicle::rotor_radius, &found.rotor_radius}},
                  {"radius", {&Vehicle::radius, &found.radius}},
                  {"height", {&Vehicle::height, &found.height}}}};
  for (const auto& [key, number] : numbers) {
    if (*number.second) vehicle.*number.first = **number.second;
    lines.add(key, *number.second);
  }
  // What the file leaves open may make it fly, so that the scenario is checked once it is complete. Each
  // number that it has is sound in any case.
  try {
    check_parameters(vehicle);
    if (found.k_f && spins && !found.rotors.empty()) vehicle.check();
  } catch (const std::invalid_argument& error) {
    file.refuse(file.root(), "a model", fmt::format("a multirotor that flies ({})", error.what()));
  }

  const std::string robot = options.agent.empty() ? "uav0" : options.agent;
  Imported made;
  made.what = fmt::format("the vehicle of {}", robot);
  made.text = fmt::format("# Of {}, by `sightline import`, about the common centre of mass of its parts.\n",
                          file_name(file.name()));
  for (const std::string& remark : found.remarks) made.text += fmt::format("# {}\n", remark);
  made.text += fmt::format(
      "# Not in the file, so as in the preset, x500 if none is stated: {}, drag, "
      "gains.\n[agent.{}.vehicle]\n{}",
      fmt::join(lines.missing, ", "), robot, lines.text);
  const double off = std::max({std::abs(body.I(0, 1)), std::abs(body.I(0, 2)), std::abs(body.I(1, 2))});
  if (off > 0.01 * inertia[0])
    made.notes.push_back(fmt::format("products of inertia have no counterpart, {:.3g} kg m^2", off));
  made.notes.insert(made.notes.end(), found.notes.begin(), found.notes.end());
  if (!spins) made.notes.emplace_back("the file does not state the spin of rotors: complete spin = []");
  made.notes.push_back(fmt::format("{}, drag and gains stay those of the preset, x500 if none is stated",
                                   fmt::join(lines.missing, ", ")));
  return made;
}

Imported import_vehicle(std::span<const ImportFile> files, const ImportOptions& options) {
  std::vector<std::unique_ptr<XmlFile>> all;
  for (const ImportFile& file : files) all.push_back(std::make_unique<XmlFile>(file));
  const XmlFile& first = *all[0];
  const auto kind = [](const XmlFile& file) { return std::string_view(file.root().Name()); };
  for (const auto& file : all) {
    const bool known = kind(*file) == "sdf" || kind(*file) == "robot" || kind(*file) == "mujoco";
    if (!known) file->refuse(file->root(), "another kind of XML", "SDF, URDF or MJCF of a multirotor");
    const bool more = file != all[0] && (kind(first) != "sdf" || kind(*file) != "sdf");
    if (more) file->refuse(file->root(), "one more file", "one URDF or MJCF, or the files of one SDF");
  }
  if (kind(first) == "robot") return vehicle_table(describe_urdf(first), first, options);
  if (kind(first) == "mujoco") return vehicle_table(describe_mjcf(first), first, options);
  return vehicle_table(describe_sdf(all), first, options);
}

}  // namespace sightline
