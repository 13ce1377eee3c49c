#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/character.hpp"
#include "sightline/import/vehicle_description.hpp"
#include "sightline/model.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

using UrdfElement = tinyxml2::XMLElement;

PartPose urdf_origin(const XmlFile& file, const UrdfElement& parent) {
  const UrdfElement* const at = parent.FirstChildElement("origin");
  if (at == nullptr) return {};
  std::vector<double> p = file.attribute(*at, "xyz", 3, 3, {-1e3, 1e3, "x y z in m"});
  std::vector<double> turns = file.attribute(*at, "rpy", 3, 3, {-1e3, 1e3, "roll pitch yaw in rad"});
  p.resize(3), turns.resize(3);
  return {{p[0], p[1], p[2]}, turn_z(turns[2]) * turn_y(turns[1]) * turn_x(turns[0])};
}

/// Whether a link is that of a propeller: "prop0_link" or "rotor_0", but not "quadrotor" or
/// "prop_guard".
bool is_propeller(const std::string& link) {
  const std::string name = lower_case(link);
  if (name.find("guard") != std::string::npos) return false;
  for (const std::string_view word : {"prop", "rotor"})
    for (std::size_t at = name.find(word); at != std::string::npos; at = name.find(word, at + 1))
      if (at == 0 || name[at - 1] < 'a' || name[at - 1] > 'z') return true;
  return false;
}

/// The links of a URDF in the frame of its root link, with all joints at zero.
class UrdfTree {
 public:
  explicit UrdfTree(const XmlFile& file) : file_(file) {
    const std::vector<const UrdfElement*> all = elements_of(file.root(), "link");
    if (all.empty() || all.size() > described_parts_max)
      file.refuse(file.root(), "its links", fmt::format("1 to {} links", described_parts_max));
    for (const UrdfElement* const at : all) {
      const std::string name = file.attribute_word(*at, "name", "a name of its own");
      if (!links_.emplace(name, at).second) file.refuse(*at, name, "a name of its own");
      order_.push_back(name);
    }
    for (const UrdfElement* const at : elements_of(file.root(), "joint")) read_joint(*at);
    for (const std::string& name : order_)
      if (!above_.contains(name)) roots_.push_back(name);
    if (roots_.size() != 1)
      file.refuse(file.root(), fmt::format("{} links without a parent", roots_.size()), "one");
    // A link is placed once its parent is; links in a circle never are.
    for (std::size_t placed = 0; placed != poses.size() || placed == 0;) {
      placed = poses.size();
      poses.emplace(roots_[0], PartPose{});
      for (const auto& [child, joint] : above_)
        if (const auto parent = poses.find(joint.parent); parent != poses.end())
          poses.emplace(child, parent->second * joint.origin);
    }
    if (poses.size() != order_.size())
      file.refuse(file.root(), "joints in a circle", "a tree of links and joints");
  }

  const UrdfElement& root() const { return *links_.at(roots_[0]); }
  const UrdfElement& link(const std::string& name) const { return *links_.at(name); }
  const std::vector<std::string>& order() const { return order_; }  ///< of the file

  std::map<std::string, PartPose> poses{};
  std::map<std::string, std::string> carried{};  ///< links by the joints that carry them

 private:
  struct Joint {
    std::string parent;
    PartPose origin;
  };

  std::string linked(const UrdfElement& joint, const char* end) const {
    const UrdfElement* const at = joint.FirstChildElement(end);
    if (at == nullptr)
      file_.refuse(joint, fmt::format("without {}", end), fmt::format("<{}> with a link", end));
    const std::string name = file_.attribute_word(*at, "link", "the name of a link");
    if (!links_.contains(name)) file_.refuse(*at, name, "a link of this file");
    return name;
  }
  void read_joint(const UrdfElement& at) {
    const std::string child = linked(at, "child");
    if (const char* const name = at.Attribute("name")) carried[name] = child;
    if (!above_.emplace(child, Joint{linked(at, "parent"), urdf_origin(file_, at)}).second)
      file_.refuse(at, child, "one joint above each link");
  }

  const XmlFile& file_;
  std::map<std::string, const UrdfElement*> links_;
  std::map<std::string, Joint> above_;
  std::vector<std::string> order_, roots_;
};

RigidPart urdf_mass(const XmlFile& file, const UrdfElement& inertial, const PartPose& place) {
  const UrdfElement* const mass = inertial.FirstChildElement("mass");
  if (mass == nullptr) file.refuse(inertial, "without mass", "<mass> with its value");
  const UrdfElement* const at = inertial.FirstChildElement("inertia");
  if (at == nullptr) file.refuse(inertial, "without inertia", "<inertia> with ixx, iyy and izz");
  const Mat<3, 3> I = moments([&](const char* name) {
    return file.attribute(*at, name, any_number("a moment of inertia in kg m^2"),
                          name[1] == name[2] ? std::nullopt : std::optional(0.0));
  });
  return {file.attribute(*mass, "value", not_negative(">= 0 kg")), place.p,
          place.R * I * transposed(place.R)};
}

/// The element <properties> of gym-pybullet-drones: thrust and torque of a rotor over the square of its
/// speed in revolutions per minute.
void add_properties(VehicleDescription& to, const XmlFile& file, const UrdfElement& at) {
  constexpr double rpm = std::numbers::pi / 30;  // [rad/s]
  const double kf = file.attribute(at, "kf", positive("> 0 N/rpm^2"));
  const double km = file.attribute(at, "km", positive("> 0 N m/rpm^2"));
  to.k_f = kf / (rpm * rpm), to.k_m = km / kf;
  if (at.Attribute("prop_radius") != nullptr)
    to.rotor_radius = file.attribute(at, "prop_radius", positive("> 0 m"));
  if (at.Attribute("drag_coeff_xy") != nullptr)
    to.rotor_drag = file.attribute(at, "drag_coeff_xy", not_negative(">= 0 N s^2/m"));
  if (to.rotors.empty()) return;
  double mass = 0.0, reach = 0.0;
  for (const RigidPart& part : to.parts) mass += part.m;
  for (const DescribedRotor& rotor : to.rotors) reach = std::max(reach, norm(rotor.p.x, rotor.p.y));
  const double lift = file.attribute(at, "thrust2weight", positive("> 0"));
  to.speed_max = std::sqrt(lift * mass * gravity / (static_cast<double>(to.rotors.size()) * *to.k_f));
  to.remarks.push_back(fmt::format("The greatest thrust is {} times the weight.", lift));
  if (at.Attribute("arm") == nullptr) return;
  const double arm = file.attribute(at, "arm", positive("> 0 m"));
  if (std::abs(arm - reach) > 0.02 * arm)
    to.notes.push_back(
        fmt::format("arm is {} m, the links of the rotors are at {:.4g} m and count", arm, reach));
}

/// The only collision of the root link, if it is an upright cylinder.
void add_cylinder(VehicleDescription& to, const XmlFile& file, const UrdfElement& link) {
  const std::vector<const UrdfElement*> all = elements_of(link, "collision");
  const UrdfElement* const shape = all.size() == 1 ? all[0]->FirstChildElement("geometry") : nullptr;
  const UrdfElement* const cylinder = shape != nullptr ? shape->FirstChildElement("cylinder") : nullptr;
  if (cylinder == nullptr || std::abs(urdf_origin(file, *all[0]).R(2, 2)) < 0.999) return;
  to.radius = file.attribute(*cylinder, "radius", positive("> 0 m"));
  to.height = file.attribute(*cylinder, "length", positive("> 0 m"));
}

}  // namespace

VehicleDescription describe_urdf(const XmlFile& file) {
  for (const UrdfElement* const at : elements_of(file.root()))
    if (std::string_view(at->Name()).starts_with("xacro:"))
      file.refuse(*at, "xacro", "URDF, which xacro FILE prints");
  const UrdfTree tree(file);
  VehicleDescription found;
  std::vector<DescribedRotor> propellers;
  for (const std::string& name : tree.order()) {
    const UrdfElement* const inertial = tree.link(name).FirstChildElement("inertial");
    const PartPose place =
        tree.poses.at(name) * (inertial != nullptr ? urdf_origin(file, *inertial) : PartPose{});
    if (inertial != nullptr) found.parts.push_back(urdf_mass(file, *inertial, place));
    if (&tree.link(name) != &tree.root() && is_propeller(name)) propellers.push_back({place.p});
  }
  if (found.parts.empty()) file.refuse(file.root(), "no <inertial>", "links with masses");
  for (const UrdfElement* const gazebo : elements_of(file.root(), "gazebo"))
    for (const UrdfElement* const plugin : elements_of(*gazebo, "plugin"))
      if (plugin->FirstChildElement("motorConstant") != nullptr)
        add_motor(found, file, *plugin, tree.poses, tree.carried);
  // Without motors, the links of propellers state the places of rotors.
  if (found.rotors.empty()) {
    found.rotors = std::move(propellers);
    if (const UrdfElement* const at = file.root().FirstChildElement("properties"))
      add_properties(found, file, *at);
  }
  add_cylinder(found, file, tree.root());
  return found;
}

}  // namespace sightline
