#include <fmt/format.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/import/vehicle_description.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

using tinyxml2::XMLElement;

PartPose sdf_pose(const XmlFile& file, const XMLElement& parent) {
  const XMLElement* const at = parent.FirstChildElement("pose");
  if (at == nullptr) return {};
  if (at->Attribute("relative_to") != nullptr || at->Attribute("degrees") != nullptr)
    file.refuse(*at, "with attributes", "a pose in the frame of its parent, in rad");
  const std::vector<double> v =
      file.numbers(parent, "pose", 6, {-1e3, 1e3, "x y z roll pitch yaw in m and rad"});
  return {{v[0], v[1], v[2]}, turn_z(v[5]) * turn_y(v[4]) * turn_x(v[3])};
}

RigidPart sdf_mass(const XmlFile& file, const XMLElement& inertial, const PartPose& link) {
  const PartPose place = link * sdf_pose(file, inertial);
  const double m = file.number(inertial, "mass", positive("> 0 kg"));
  const XMLElement* const at = inertial.FirstChildElement("inertia");
  if (at == nullptr) file.refuse(inertial, "without inertia", "<inertia> with ixx, iyy and izz");
  const Mat<3, 3> I = moments([&](const char* name) {
    return file.number(*at, name, any_number("a moment of inertia in kg m^2"),
                       name[1] == name[2] ? std::nullopt : std::optional(0.0));
  });
  return {m, place.p, place.R * I * transposed(place.R)};
}

/// Links, joints and motors of all models in the files.
class SdfVehicle {
 public:
  void read(const XmlFile& file) {
    for_each(file, file.root(), [&](const XMLElement& at) {
      const std::string_view name = at.Name();
      if (name == "link") read_link(file, at);
      if (name == "joint") read_joint(file, at);
      if (name == "include") read_include(at);
    });
  }
  void read_motors(const XmlFile& file) {
    for_each(file, file.root(), [&](const XMLElement& at) {
      if (std::string_view(at.Name()) == "plugin" && at.FirstChildElement("motorConstant") != nullptr)
        add_motor(found, file, at, links_, joints_);
    });
  }

  VehicleDescription found{};

 private:
  template <class Do>
  void for_each(const XmlFile& file, const XMLElement& root, const Do& take) {
    for (const XMLElement* const at : elements_of(root)) {
      take(*at);
      const std::string_view name = at->Name();
      if (name != "model" && name != "world") continue;
      if (at->FirstChildElement("pose") != nullptr && name == "model" &&
          std::string_view(root.Name()) == "model")
        file.refuse(*at, "a model in a model", "links and motors of one model");
      for_each(file, *at, take);
    }
  }
  void read_link(const XmlFile& file, const XMLElement& at) {
    const PartPose pose = sdf_pose(file, at);
    const char* const name = at.Attribute("name");
    if (name == nullptr || !links_.emplace(name, pose).second)
      file.refuse(at, name == nullptr ? "without a name" : name, "a name of its own");
    if (const XMLElement* const inertial = at.FirstChildElement("inertial"))
      found.parts.push_back(sdf_mass(file, *inertial, pose));
    if (found.parts.size() > described_parts_max)
      file.refuse(at, "one of many", fmt::format("at most {} links", described_parts_max));
  }
  void read_include(const XMLElement& at) {
    const XMLElement* const uri = at.FirstChildElement("uri");
    const char* const text = uri != nullptr ? uri->GetText() : nullptr;
    found.notes.push_back(fmt::format(
        "the parts of the included {} count if its file is given{}", one_line(text != nullptr ? text : "?"),
        at.FirstChildElement("pose") != nullptr ? ", and at the origin: its pose has no counterpart" : ""));
  }
  void read_joint(const XmlFile& file, const XMLElement& at) {
    if (const char* const name = at.Attribute("name"))
      joints_[name] = file.word(at, "child", "the link that it carries");
  }

  std::map<std::string, PartPose> links_;
  std::map<std::string, std::string> joints_;
};

}  // namespace

VehicleDescription describe_sdf(std::span<const std::unique_ptr<XmlFile>> files) {
  SdfVehicle vehicle;
  for (const auto& file : files) vehicle.read(*file);
  for (const auto& file : files) vehicle.read_motors(*file);
  const XmlFile& first = *files[0];
  if (vehicle.found.parts.empty()) first.refuse(first.root(), "no <inertial>", "links with masses");
  if (vehicle.found.rotors.empty())
    first.refuse(first.root(), "no motor", "plugins with <motorConstant> (MulticopterMotorModel)");
  return vehicle.found;
}

}  // namespace sightline
