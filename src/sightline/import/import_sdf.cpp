#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "sightline/estimator.hpp"
#include "sightline/import/kinds.hpp"
#include "sightline/vehicle.hpp"

namespace sightline {
namespace {

using tinyxml2::XMLElement;

constexpr std::size_t parts_max = 256;  // links, and motors
constexpr std::string_view of_pose = "x y z roll pitch yaw in m and rad";

/// A file with its elements; every error states file, line, element, text and what was expected.
class SdfFile {
 public:
  explicit SdfFile(const ImportFile& file) : name_(file.name) {
    document_.Parse(file.text.data(), file.text.size());
    if (document_.Error())
      throw ScenarioError(name_, static_cast<std::size_t>(std::max(1, document_.ErrorLineNum())),
                          fmt::format("cannot be read as XML ({})", document_.ErrorName()));
    if (root() == nullptr) throw ScenarioError(name_, 1, "XML without an element, expected SDF");
  }
  const XMLElement* root() const { return document_.RootElement(); }

  [[noreturn]] void refuse(const XMLElement& at, std::string_view text, std::string_view expected) const {
    throw ScenarioError(name_, static_cast<std::size_t>(std::max(1, at.GetLineNum())),
                        fmt::format("<{}> = {}, expected {}", at.Name(), shortened(text, 60), expected));
  }
  /// `count` numbers of an element; without it those of `missing`, or none of which it must have.
  std::vector<double> numbers(const XMLElement& parent, const char* name, std::size_t count,
                              const Range& range, std::optional<double> missing = std::nullopt) const {
    const XMLElement* const at = parent.FirstChildElement(name);
    if (at == nullptr) {
      if (!missing)
        refuse(parent, "without " + std::string(name), fmt::format("<{}> with {}", name, range.expected));
      return std::vector<double>(count, *missing);
    }
    const std::string_view text = at->GetText() != nullptr ? at->GetText() : "";
    std::vector<double> values;
    for (std::size_t i = 0; i < text.size();) {
      if (std::isspace(static_cast<unsigned char>(text[i])) != 0) {
        ++i;
        continue;
      }
      double value = 0.0;
      const auto [end, error] = std::from_chars(text.data() + i, text.data() + text.size(), value);
      if (error != std::errc{} || !range.holds(value)) refuse(*at, text, range.expected);
      values.push_back(value);
      i = static_cast<std::size_t>(end - text.data());
    }
    if (values.size() != count) refuse(*at, text, fmt::format("{} numbers, {}", count, range.expected));
    return values;
  }
  double number(const XMLElement& parent, const char* name, const Range& range,
                std::optional<double> missing = std::nullopt) const {
    return numbers(parent, name, 1, range, missing)[0];
  }
  std::string word(const XMLElement& parent, const char* name, std::string_view expected) const {
    const XMLElement* const at = parent.FirstChildElement(name);
    if (at == nullptr || at->GetText() == nullptr) refuse(parent, "without " + std::string(name), expected);
    return at->GetText();
  }

 private:
  std::string name_;
  tinyxml2::XMLDocument document_;
};

/// A rigid part: a pose in the frame of its parent, or of the model.
struct SdfPose {
  Vec3<double> p{};
  Mat<3, 3> R = identity<3>();
};

SdfPose read_pose(const SdfFile& file, const XMLElement& parent) {
  const XMLElement* const at = parent.FirstChildElement("pose");
  if (at == nullptr) return {};
  if (at->Attribute("relative_to") != nullptr || at->Attribute("degrees") != nullptr)
    file.refuse(*at, "with attributes", "a pose in the frame of its parent, in rad");
  const std::vector<double> v = file.numbers(parent, "pose", 6, {-1e3, 1e3, of_pose});
  return {{v[0], v[1], v[2]}, turn_z(v[5]) * turn_y(v[4]) * turn_x(v[3])};
}

struct Mass {
  double m;
  Vec3<double> p;  // of its centre, in the model
  Mat<3, 3> I;     // about that centre, in the axes of the model
};

Mass read_mass(const SdfFile& file, const XMLElement& inertial, const SdfPose& link) {
  const SdfPose own = read_pose(file, inertial);
  const double m = file.number(inertial, "mass", positive("> 0 kg"));
  const XMLElement* const at = inertial.FirstChildElement("inertia");
  if (at == nullptr) file.refuse(inertial, "without inertia", "<inertia> with ixx, iyy and izz");
  const Range any = any_number("a moment of inertia in kg m^2");
  const auto of = [&](const char* name) {
    return file.number(*at, name, any, name[1] == name[2] ? std::nullopt : std::optional(0.0));
  };
  Mat<3, 3> I;
  I(0, 0) = of("ixx"), I(1, 1) = of("iyy"), I(2, 2) = of("izz");
  I(0, 1) = I(1, 0) = of("ixy"), I(0, 2) = I(2, 0) = of("ixz"), I(1, 2) = I(2, 1) = of("iyz");
  const Mat<3, 3> R = link.R * own.R;
  return {m, link.p + link.R * own.p, R * I * transposed(R)};
}

/// All parts as one rigid body.
Mass together(const std::vector<Mass>& all) {
  Mass sum{0.0, {}, {}};
  for (const Mass& one : all) sum.m += one.m, sum.p = sum.p + one.m * one.p;
  sum.p = (1 / sum.m) * sum.p;
  for (const Mass& one : all) {
    const Mat<3, 3> K = cross_matrix(one.p - sum.p);
    sum.I += one.I + one.m * (K * transposed(K));
  }
  return sum;
}

struct SdfMotor {
  Vec3<double> p;  // of its rotor, in the model
  double spin, k_f, k_m, speed_max, tau_up, tau_down, drag;
};

/// Links, joints and motors of all models in the files.
class SdfVehicle {
 public:
  void read(const SdfFile& file) {
    for_each(file, *file.root(), [&](const XMLElement& at) {
      const std::string_view name = at.Name();
      if (name == "link") read_link(file, at);
      if (name == "joint") read_joint(file, at);
      if (name == "include") read_include(at);
    });
  }
  void read_motors(const SdfFile& file) {
    for_each(file, *file.root(), [&](const XMLElement& at) {
      if (std::string_view(at.Name()) == "plugin" && at.FirstChildElement("motorConstant") != nullptr)
        read_motor(file, at);
    });
  }

  std::vector<Mass> masses{};
  std::vector<SdfMotor> motors{};
  std::vector<std::string> notes{};

 private:
  template <class Do>
  void for_each(const SdfFile& file, const XMLElement& root, const Do& take) {
    for (const XMLElement* at = root.FirstChildElement(); at != nullptr; at = at->NextSiblingElement()) {
      take(*at);
      if (masses.size() > parts_max || motors.size() > parts_max)
        file.refuse(*at, "one of many", fmt::format("at most {} links and motors", parts_max));
      const std::string_view name = at->Name();
      if (name == "model" || name == "world") {
        if (at->FirstChildElement("pose") != nullptr && name == "model" &&
            std::string_view(root.Name()) == "model")
          file.refuse(*at, "a model in a model", "links and motors of one model");
        for_each(file, *at, take);
      }
    }
  }
  void read_link(const SdfFile& file, const XMLElement& at) {
    const SdfPose pose = read_pose(file, at);
    const char* const name = at.Attribute("name");
    if (name == nullptr || !links_.emplace(name, pose).second)
      file.refuse(at, name == nullptr ? "without a name" : name, "a name of its own");
    if (const XMLElement* const inertial = at.FirstChildElement("inertial"))
      masses.push_back(read_mass(file, *inertial, pose));
  }
  void read_include(const XMLElement& at) {
    const XMLElement* const uri = at.FirstChildElement("uri");
    const char* const text = uri != nullptr ? uri->GetText() : nullptr;
    notes.push_back(fmt::format(
        "the parts of the included {} count if its file is given{}", one_line(text != nullptr ? text : "?"),
        at.FirstChildElement("pose") != nullptr ? ", and at the origin: its pose has no counterpart" : ""));
  }
  void read_joint(const SdfFile& file, const XMLElement& at) {
    if (const char* const name = at.Attribute("name"))
      joints_[name] = file.word(at, "child", "the link that it carries");
  }
  void read_motor(const SdfFile& file, const XMLElement& at) {
    const bool by_link = at.FirstChildElement("linkName") != nullptr;
    std::string link = file.word(at, by_link ? "linkName" : "jointName", "the link of its rotor");
    if (!by_link && joints_.contains(link)) link = joints_[link];
    const auto place = links_.find(link);
    if (place == links_.end()) file.refuse(at, link, "a link of these files: give the file that has it too");
    if (!(place->second.R(2, 2) > 0.999)) file.refuse(at, link, "a rotor that thrusts along z of its model");
    const std::string turns = file.word(at, "turningDirection", "cw or ccw");
    if (turns != "cw" && turns != "ccw")
      file.refuse(*at.FirstChildElement("turningDirection"), turns, "cw or ccw");
    const SdfMotor motor{place->second.p,
                         turns == "ccw" ? 1.0 : -1.0,
                         file.number(at, "motorConstant", positive("> 0 N s^2")),
                         file.number(at, "momentConstant", positive("> 0 m")),
                         file.number(at, "maxRotVelocity", positive("> 0 rad/s")),
                         file.number(at, "timeConstantUp", {0.004, 1, "0.004 to 1 s"}),
                         file.number(at, "timeConstantDown", {0.004, 1, "0.004 to 1 s"}),
                         file.number(at, "rotorDragCoefficient", not_negative(">= 0 N s^2/m"), 0.0)};
    const auto constants = [](const SdfMotor& m) {
      return std::tie(m.k_f, m.k_m, m.speed_max, m.tau_up, m.tau_down, m.drag);
    };
    if (!motors.empty() && constants(motor) != constants(motors[0]))
      file.refuse(at, link, "the constants of the first motor");
    motors.push_back(motor);
  }

  std::map<std::string, SdfPose> links_;
  std::map<std::string, std::string> joints_;
};

}  // namespace

Imported import_sdf(std::span<const ImportFile> files, const ImportOptions& options) {
  std::vector<std::unique_ptr<SdfFile>> all;
  for (const ImportFile& file : files) {
    const SdfFile& read = *all.emplace_back(std::make_unique<SdfFile>(file));
    const std::string_view root = read.root()->Name();
    if (root == "mujoco" || root == "robot")
      read.refuse(*read.root(), root == "robot" ? "URDF" : "MJCF",
                  "SDF with motors; vehicle.model of the world \"mujoco\" reads MJCF as it is");
    if (root != "sdf")
      read.refuse(*read.root(), "another kind of XML", "SDF with motors (MulticopterMotorModel)");
  }
  SdfVehicle found;
  for (const auto& file : all) found.read(*file);
  for (const auto& file : all) found.read_motors(*file);
  const SdfFile& first = *all[0];
  if (found.masses.empty()) first.refuse(*first.root(), "no <inertial>", "links with masses");
  if (found.motors.empty())
    first.refuse(*first.root(), "no motor", "plugins with <motorConstant> (MulticopterMotorModel)");

  const Mass body = together(found.masses);
  const SdfMotor& motor = found.motors[0];
  Vehicle vehicle;
  vehicle.mass = body.m;
  vehicle.inertia = {body.I(0, 0), body.I(1, 1), body.I(2, 2)};
  vehicle.rotor_x.clear(), vehicle.rotor_y.clear(), vehicle.spin.clear();
  for (const SdfMotor& one : found.motors) {
    vehicle.rotor_x.push_back(one.p.x - body.p.x);
    vehicle.rotor_y.push_back(one.p.y - body.p.y);
    vehicle.spin.push_back(one.spin);
  }
  vehicle.k_f = motor.k_f, vehicle.k_m = motor.k_m, vehicle.speed_max = motor.speed_max;
  vehicle.tau_up = motor.tau_up, vehicle.tau_down = motor.tau_down, vehicle.rotor_drag = motor.drag;
  try {
    vehicle.check();
  } catch (const std::invalid_argument& error) {
    first.refuse(*first.root(), "a model", fmt::format("a multirotor that flies ({})", error.what()));
  }
  const std::string robot = options.agent.empty() ? "uav0" : options.agent;
  Imported made;
  made.what = fmt::format("the vehicle of {}", robot);
  const std::array<double, 3> inertia = {vehicle.inertia.x, vehicle.inertia.y, vehicle.inertia.z};
  made.text = fmt::format(
      "# Of {}, by `sightline import`, about the common centre of mass of its "
      "links.\n[agent.{}.vehicle]\nmass = {}\n"
      "inertia = {}\nrotor_x = {}\nrotor_y = {}\nspin = {}\nk_f = {}\nk_m = {}\nspeed_max = {}\ntau_up = {}\n"
      "tau_down = {}\nrotor_drag = {}\n",
      file_name(files[0].name), robot, toml_number(vehicle.mass), toml_numbers(inertia),
      toml_numbers(vehicle.rotor_x), toml_numbers(vehicle.rotor_y), toml_numbers(vehicle.spin),
      toml_number(vehicle.k_f), toml_number(vehicle.k_m), toml_number(vehicle.speed_max),
      toml_number(vehicle.tau_up), toml_number(vehicle.tau_down), toml_number(vehicle.rotor_drag));
  const double off = std::max({std::abs(body.I(0, 1)), std::abs(body.I(0, 2)), std::abs(body.I(1, 2))});
  if (off > 0.01 * inertia[0])
    made.notes.push_back(fmt::format("products of inertia have no counterpart, {:.3g} kg m^2", off));
  made.notes.insert(made.notes.end(), found.notes.begin(), found.notes.end());
  made.notes.emplace_back("rotor_radius, radius, height, drag and gains stay those of the x500");
  return made;
}

}  // namespace sightline
