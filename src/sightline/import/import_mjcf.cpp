#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "sightline/base/character.hpp"
#include "sightline/import/vehicle_description.hpp"
#include "sightline/scenario.hpp"
#include "sightline/vehicle.hpp"

namespace sightline {
namespace {

using MjcfElement = tinyxml2::XMLElement;

constexpr Range of_place = {-1e3, 1e3, "numbers in m, at most 1e3"};
constexpr Range of_axis = any_number("a rotation");
constexpr double least_axis = 1e-9;  // length that still has a direction

Vec3<double> mjcf_vector(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

/// What the sections <compiler> and <default> say.
class MjcfSettings {
 public:
  explicit MjcfSettings(const XmlFile& file) : file_(file) {
    for (const MjcfElement* const at : elements_of(file.root(), "compiler")) read_compiler(*at);
    for (const MjcfElement* const at : elements_of(file.root(), "default")) read_class(*at, "", "main");
  }

  /// The element that has an attribute: itself, or the one of its class, or of a class above; null.
  /// @param kind  of the elements in the classes
  const MjcfElement* with(const MjcfElement& at, const char* attribute, const char* kind,
                          const std::string& of_body) const {
    if (at.Attribute(attribute) != nullptr) return &at;
    const char* const own = at.Attribute("class");
    std::string name = own != nullptr ? own : of_body;
    if (name != "main" && !classes_.contains(name)) file_.refuse(at, name, "a class of <default>");
    for (auto in = classes_.find(name); in != classes_.end(); in = classes_.find(in->second.above))
      for (const MjcfElement* const section : in->second.sections)
        for (const MjcfElement* const one : elements_of(*section))
          if (is_of(one->Name(), kind) && one->Attribute(attribute) != nullptr) return one;
    return nullptr;
  }

  /// `least` to `most` numbers of an attribute, its own or by class; empty without it.
  std::vector<double> numbers(const MjcfElement& at, const char* attribute, const char* kind,
                              const std::string& of_body, std::size_t least, std::size_t most,
                              const Range& range) const {
    const MjcfElement* const from = with(at, attribute, kind, of_body);
    return from == nullptr ? std::vector<double>{} : file_.attribute(*from, attribute, least, most, range);
  }

  /// The pose by pos, and by quat, euler, axisangle, xyaxes or zaxis.
  PartPose pose(const MjcfElement& at, const char* kind, const std::string& of_body) const {
    const auto of = [&](const char* name, std::size_t count, const Range& range) {
      return numbers(at, name, kind, of_body, count, count, range);
    };
    PartPose place;
    if (const auto p = of("pos", 3, of_place); !p.empty()) place.p = mjcf_vector(p);
    if (const auto q = of("quat", 4, of_axis); !q.empty()) {
      const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      if (!(length > least_axis)) file_.refuse(at, "quat of 0", "a rotation");
      const Mat<3, 3> K = cross_matrix((1 / length) * Vec3<double>{q[1], q[2], q[3]});
      place.R = identity<3>() + (2 * q[0] / length) * K + 2.0 * (K * K);
    } else if (const auto e = of("euler", 3, of_axis); !e.empty()) {
      for (std::size_t i = 0; i < 3; ++i) {
        const char axis = axes_[i];
        const double a = angle_ * e[i];
        const Mat<3, 3> R = axis == 'x' ? turn_x(a) : axis == 'y' ? turn_y(a) : turn_z(a);
        place.R = axis == sequence_[i] ? place.R * R : R * place.R;
      }
    } else if (const auto a = of("axisangle", 4, of_axis); !a.empty()) {
      place.R = turn(angle_ * a[3] * direction(at, mjcf_vector(a)));
    } else if (const auto z = of("zaxis", 3, of_axis); !z.empty()) {
      place.R = to_axis(direction(at, mjcf_vector(z)));
    } else if (const auto axes = of("xyaxes", 6, of_axis); !axes.empty()) {
      const Vec3<double> x = direction(at, mjcf_vector(axes)), free = {axes[3], axes[4], axes[5]};
      const Vec3<double> y = direction(at, free - dot(x, free) * x), up = cross_matrix(x) * y;
      place.R = {{{{x.x, y.x, up.x}, {x.y, y.y, up.y}, {x.z, y.z, up.z}}}};
    }
    return place;
  }
  /// The shortest turn that takes z to a unit vector.
  static Mat<3, 3> to_axis(const Vec3<double>& z) {
    const Vec3<double> axis = cross_matrix(Vec3<double>{0, 0, 1}) * z;
    const double sine = norm(axis);
    if (sine < least_axis) return z.z > 0 ? identity<3>() : turn_x(std::numbers::pi);
    return turn((atan2(sine, z.z) / sine) * axis);
  }
  Vec3<double> direction(const MjcfElement& at, const Vec3<double>& v) const {
    const double length = norm(v);
    if (!(length > least_axis)) file_.refuse(at, "an axis of length 0", "a direction");
    return (1 / length) * v;
  }

  bool geoms_alone = false, inertials_alone = false;  ///< inertiafromgeom true, false; else by the body
  bool limits = true;                                 ///< a range alone limits
  std::vector<const MjcfElement*> includes{};         ///< in <default>

 private:
  struct Class {
    std::string above;
    std::vector<const MjcfElement*> sections;
  };

  /// The defaults of all actuators are one.
  static bool is_of(std::string_view name, std::string_view kind) {
    return name == kind || (kind == "motor" && name == "general") || (kind == "general" && name == "motor");
  }
  void read_class(const MjcfElement& at, const std::string& above, const std::string& otherwise) {
    const char* const own = at.Attribute("class");
    const std::string name = own != nullptr ? own : otherwise;
    if (name.empty()) file_.refuse(at, "without class", "the name of a class");
    Class& one = classes_[name];
    if (one.sections.empty()) one.above = above;
    if (one.above != above) file_.refuse(at, name, "each class once");
    one.sections.push_back(&at);
    for (const MjcfElement* const below : elements_of(at, "default")) read_class(*below, name, "");
    for (const MjcfElement* const below : elements_of(at, "include")) includes.push_back(below);
  }
  void read_compiler(const MjcfElement& at) {
    const auto is = [&](const char* key, std::string_view value) {
      const char* const text = at.Attribute(key);
      return text != nullptr && text == value;
    };
    // One more <compiler> changes only what it states.
    if (at.Attribute("angle") != nullptr) angle_ = is("angle", "radian") ? 1.0 : std::numbers::pi / 180;
    if (at.Attribute("autolimits") != nullptr) limits = !is("autolimits", "false");
    if (at.Attribute("inertiafromgeom") != nullptr)
      geoms_alone = is("inertiafromgeom", "true"), inertials_alone = is("inertiafromgeom", "false");
    for (const char* const key : {"settotalmass", "boundmass", "boundinertia", "balanceinertia"})
      if (at.Attribute(key) != nullptr && !is(key, "false") && !is(key, "0"))
        file_.refuse(at, key, "masses as parts have them");
    if (at.Attribute("inertiagrouprange") != nullptr && !is("inertiagrouprange", "0 5"))
      file_.refuse(at, "inertiagrouprange", "masses of all groups of geoms");
    if (at.Attribute("coordinate") != nullptr && !is("coordinate", "local"))
      file_.refuse(at, "coordinate", "poses in the frame of the parent (local)");
    if (const char* const text = at.Attribute("eulerseq")) {
      sequence_ = text;
      const bool sound = sequence_.size() == 3 && sequence_.find_first_not_of("xyzXYZ") == std::string::npos;
      if (!sound) file_.refuse(at, sequence_, "three of x, y, z, X, Y, Z");
      axes_ = lower_case(sequence_);
    }
  }

  const XmlFile& file_;
  std::map<std::string, Class> classes_;
  double angle_ = std::numbers::pi / 180;            // of the unit of angles [rad]
  std::string sequence_ = "xyz", axes_ = sequence_;  // in capitals: about axes that stay; without capitals
};

/// The body that flies, as one rigid body.
class MjcfVehicle {
 public:
  explicit MjcfVehicle(const XmlFile& file) : file_(file), settings_(file) {
    for (const MjcfElement* const world : elements_of(file.root(), "worldbody")) find_bodies(*world);
    const auto free = std::count(flies_.begin(), flies_.end(), true);
    if (free != 1 && bodies_.size() != 1)
      file.refuse(file.root(), fmt::format("{} bodies, {} with a free joint", bodies_.size(), free),
                  "one that flies");
    const std::size_t chosen =
        free == 1 ? static_cast<std::size_t>(std::find(flies_.begin(), flies_.end(), true) - flies_.begin())
                  : 0;
    read_body(*bodies_[chosen], {}, "main");
    if (found.parts.empty()) file.refuse(*bodies_[chosen], "no mass", "<inertial>, or geoms with masses");
    for (const MjcfElement* const section : elements_of(file.root(), "actuator")) {
      for (const MjcfElement* const at : elements_of(*section)) {
        if (std::string_view(at->Name()) == "include") note_include(*at);
        read_actuator(*at);
      }
    }
    add_rotors();
    for (const MjcfElement* const at : settings_.includes) note_include(*at);
    for (const MjcfElement* const at : elements_of(file.root(), "include")) note_include(*at);
  }

  VehicleDescription found{};

 private:
  struct Thrust {
    Vec3<double> p;
    std::optional<double> greatest;  // [N]
    double torque;                   // about z, over the thrust [m]
  };

  void note_include(const MjcfElement& at) {
    found.notes.push_back(fmt::format("what is in the included {} does not count",
                                      one_line(file_.attribute_word(at, "file", "the name of a file"))));
  }
  void find_bodies(const MjcfElement& parent) {
    for (const MjcfElement* const at : elements_of(parent)) {
      const std::string_view name = at->Name();
      if (name == "frame") find_bodies(*at);
      if (name == "include") note_include(*at);
      if (name != "body") continue;
      bool flies = at->FirstChildElement("freejoint") != nullptr;
      for (const MjcfElement* const joint : elements_of(*at, "joint")) {
        const char* const type = joint->Attribute("type");
        flies = flies || (type != nullptr && std::string_view(type) == "free");
      }
      bodies_.push_back(at), flies_.push_back(flies);
    }
  }
  /// @param pose  of the body in the vehicle, which is its own frame
  void read_body(const MjcfElement& body, const PartPose& pose, const std::string& above) {
    const MjcfElement* const inertial = body.FirstChildElement("inertial");
    const bool by_inertial = inertial != nullptr && !settings_.geoms_alone;
    if (by_inertial) add_inertial(*inertial, pose);
    read_children(body, pose, above, !by_inertial && !settings_.inertials_alone);
    if (found.parts.size() > described_parts_max)
      file_.refuse(body, "one of many", fmt::format("at most {} parts", described_parts_max));
  }
  void read_children(const MjcfElement& parent, const PartPose& pose, const std::string& above, bool geoms) {
    const char* const own = parent.Attribute("childclass");
    const std::string of_body = own != nullptr ? own : above;
    for (const MjcfElement* const at : elements_of(parent)) {
      const std::string_view name = at->Name();
      if (name == "body") read_body(*at, pose * settings_.pose(*at, "body", "main"), of_body);
      if (name == "frame") read_children(*at, pose * settings_.pose(*at, "frame", "main"), of_body, geoms);
      if (name == "include") note_include(*at);
      if (name == "geom" && geoms) add_geom(*at, pose, of_body);
      if (name == "replicate" || name == "attach") file_.refuse(*at, name, "bodies as they are");
      if (name != "site" || at->Attribute("name") == nullptr) continue;
      sites_[at->Attribute("name")] = pose * settings_.pose(*at, "site", of_body);
    }
  }

  void add_inertial(const MjcfElement& at, const PartPose& body) {
    const PartPose own = settings_.pose(at, "inertial", "main");
    const Range any = any_number("moments of inertia in kg m^2");
    const std::vector<double> diagonal = file_.attribute(at, "diaginertia", 3, 3, any),
                              full = file_.attribute(at, "fullinertia", 6, 6, any);
    if (diagonal.empty() && full.empty()) file_.refuse(at, "without moments", "diaginertia or fullinertia");
    Mat<3, 3> I;
    for (int i = 0; i < 3; ++i) I(i, i) = (full.empty() ? diagonal : full)[static_cast<std::size_t>(i)];
    if (!full.empty()) I(0, 1) = I(1, 0) = full[3], I(0, 2) = I(2, 0) = full[4], I(1, 2) = I(2, 1) = full[5];
    add_part(file_.attribute(at, "mass", not_negative(">= 0 kg")), body * own, I);
  }
  void add_part(double m, const PartPose& place, const Mat<3, 3>& I) {
    if (m > 0) found.parts.push_back({m, place.p, place.R * I * transposed(place.R)});
  }

  /// A geom by its mass or density, of its shape.
  void add_geom(const MjcfElement& at, const PartPose& body, const std::string& of_body) {
    const auto numbers = [&](const char* name, std::size_t least, std::size_t most, const Range& range) {
      return settings_.numbers(at, name, "geom", of_body, least, most, range);
    };
    const auto mass = numbers("mass", 1, 1, not_negative(">= 0 kg"));
    const auto density = numbers("density", 1, 1, not_negative(">= 0 kg/m^3"));
    const bool weightless = mass.empty() ? !density.empty() && density[0] == 0 : mass[0] == 0;
    if (weightless) return;
    const MjcfElement* const typed = settings_.with(at, "type", "geom", of_body);
    const bool meshed = settings_.with(at, "mesh", "geom", of_body) != nullptr;
    const std::string type = typed != nullptr ? typed->Attribute("type") : meshed ? "mesh" : "sphere";
    const bool has_fromto = settings_.with(at, "fromto", "geom", of_body) != nullptr;
    const std::size_t axes = type == "sphere" ? 1 : type == "capsule" || type == "cylinder" ? 2 : 3;
    const bool solid = type == "sphere" || type == "box" || type == "ellipsoid" || axes == 2;
    if (!solid || meshed)
      file_.refuse(
          at, meshed ? "mesh" : type,
          "a solid sphere, capsule, cylinder, ellipsoid or box: or mass = 0, or the <inertial> of its body");
    const MjcfElement* const shell = settings_.with(at, "shellinertia", "geom", of_body);
    if (shell != nullptr && std::string_view(shell->Attribute("shellinertia")) == "true")
      file_.refuse(at, "shellinertia", "a solid body");
    std::vector<double> s = numbers("size", 1, 3, not_negative(">= 0 m"));
    PartPose own = settings_.pose(at, "geom", of_body);
    if (has_fromto && type != "sphere") {
      const std::vector<double> ends = numbers("fromto", 6, 6, of_place);
      const Vec3<double> from = mjcf_vector(ends), to = {ends[3], ends[4], ends[5]};
      own = {0.5 * (from + to), MjcfSettings::to_axis(settings_.direction(at, from - to))};
      if (s.empty()) file_.refuse(at, "without size", "size > 0 m");
      s = axes == 2 ? std::vector{s[0], 0.5 * norm(to - from)}
                    : std::vector{s[0], s[0], 0.5 * norm(to - from)};
    }
    s.resize(axes);
    if (std::find(s.begin(), s.end(), 0.0) != s.end())
      file_.refuse(at, "without its size", fmt::format("size of {} numbers > 0 m", axes));
    const double volume = volume_of(type, s);
    const double m = !mass.empty() ? mass[0] : (density.empty() ? 1000.0 : density[0]) * volume;
    add_part(m, body * own, m * unit_inertia(type, s));
  }
  static double volume_of(std::string_view type, const std::vector<double>& s) {
    constexpr double ball = 4 * std::numbers::pi / 3;
    if (type == "sphere") return ball * s[0] * s[0] * s[0];
    if (type == "ellipsoid") return ball * s[0] * s[1] * s[2];
    if (type == "box") return 8 * s[0] * s[1] * s[2];
    const double tube = 2 * std::numbers::pi * s[0] * s[0] * s[1];
    return type == "cylinder" ? tube : tube + ball * s[0] * s[0] * s[0];
  }
  /// Moments of inertia of 1 kg [m^2].
  static Mat<3, 3> unit_inertia(std::string_view type, const std::vector<double>& s) {
    const double r2 = s[0] * s[0];
    Mat<3, 3> I;
    if (type == "sphere") return identity<3>(0.4 * r2);
    if (type == "ellipsoid" || type == "box") {
      const double k = type == "box" ? 1.0 / 3 : 0.2, a = r2, b = s[1] * s[1], c = s[2] * s[2];
      I(0, 0) = k * (b + c), I(1, 1) = k * (a + c), I(2, 2) = k * (a + b);
      return I;
    }
    // A tube of half the length h, and two half balls at its ends, whose centres are 3/8 r beyond.
    const double h = s[1], balls = type == "capsule" ? 4 * s[0] / (6 * h + 4 * s[0]) : 0.0, tube = 1 - balls;
    I(2, 2) = tube * r2 / 2 + balls * 0.4 * r2;
    I(0, 0) = I(1, 1) = tube * (r2 / 4 + h * h / 3) + balls * (0.4 * r2 + h * h + 0.75 * h * s[0]);
    return I;
  }

  void read_actuator(const MjcfElement& at) {
    const std::string_view kind = at.Name();
    const char* const site = at.Attribute("site");
    const auto place = site != nullptr ? sites_.find(site) : sites_.end();
    if (place == sites_.end()) return;
    const char* const name = at.Attribute("name");
    const std::string shown = shortened(one_line(name != nullptr ? name : "?"), 60);
    if ((kind != "motor" && kind != "general") || at.Attribute("refsite") != nullptr) {
      found.notes.push_back(fmt::format("actuator {} is no motor, and does not count", shown));
      return;
    }
    const auto numbers = [&](const char* key, std::size_t least, std::size_t most, const Range& range) {
      return settings_.numbers(at, key, kind.data(), "main", least, most, range);
    };
    const auto word = [&](const char* key) {
      const MjcfElement* const from = settings_.with(at, key, kind.data(), "main");
      return std::string(from != nullptr ? from->Attribute(key) : "");
    };
    std::vector<double> gear = numbers("gear", 1, 6, any_number("thrust and torque over the control"));
    if (gear.empty()) gear = {1};
    gear.resize(6);
    const Vec3<double> force = place->second.R * mjcf_vector(gear);
    const Vec3<double> torque = place->second.R * Vec3<double>{gear[3], gear[4], gear[5]};
    const double size = norm(force);
    if (!(size > least_axis)) {
      found.notes.push_back(fmt::format("actuator {} is a torque without thrust, and does not count", shown));
      return;
    }
    if (!(force.z > 0.999 * size)) file_.refuse(at, shown, "a motor that thrusts along z of its body");
    double gain = 1.0;
    if (kind == "general") {
      if (const auto all = numbers("gainprm", 1, 10, any_number("the gain of a control")); !all.empty())
        gain = all[0];
      if (!word("gaintype").empty() && word("gaintype") != "fixed")
        file_.refuse(at, word("gaintype"), "a fixed gain");
      const auto lag = numbers("dynprm", 1, 10, any_number("the lag of a control"));
      const bool filtered = word("dyntype").starts_with("filter") && !lag.empty();
      if (filtered && lag[0] >= 0.004 && lag[0] <= 1) found.tau_up = found.tau_down = lag[0];
    }
    Thrust thrust{place->second.p, std::nullopt, torque.z / size};
    for (const auto& [range, limited, factor] :
         {std::tuple{"ctrlrange", "ctrllimited", gain}, std::tuple{"forcerange", "forcelimited", 1.0}}) {
      const std::string set = word(limited);
      const auto limits = numbers(range, 2, 2, any_number("its least and greatest value"));
      if (limits.empty() || set == "false" || (set != "true" && !settings_.limits)) continue;
      const double greatest = std::max(factor * limits[0], factor * limits[1]) * size;
      thrust.greatest = std::min(greatest, thrust.greatest.value_or(greatest));
    }
    if (thrust.greatest && !(*thrust.greatest > 0)) file_.refuse(at, shown, "a greatest thrust > 0 N");
    if (!thrusts_.empty()) {
      const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-6 * std::abs(b); };
      const Thrust& first = thrusts_[0];
      const bool as_first = near(std::abs(thrust.torque), std::abs(first.torque)) &&
                            near(thrust.greatest.value_or(0), first.greatest.value_or(0));
      if (!as_first) file_.refuse(at, shown, "the gear and range of the first motor");
    }
    thrusts_.push_back(thrust);
    if (thrusts_.size() > described_parts_max)
      file_.refuse(at, "one of many", fmt::format("at most {} motors", described_parts_max));
  }
  void add_rotors() {
    if (thrusts_.empty()) return;
    const Thrust& first = thrusts_[0];
    if (thrusts_.size() == 1) {
      found.remarks.push_back(first.greatest
                                  ? fmt::format("One thrust of all rotors, at most {} N.", *first.greatest)
                                  : std::string("One thrust of all rotors, without a greatest."));
      return;
    }
    for (const Thrust& one : thrusts_)
      found.rotors.push_back({one.p, one.torque < 0 ? 1.0 : one.torque > 0 ? -1.0 : 0.0});
    if (first.torque != 0) found.k_m = std::abs(first.torque);
    if (!first.greatest) return;
    found.speed_max = Vehicle{}.speed_max;
    found.k_f = *first.greatest / (*found.speed_max * *found.speed_max);
    found.remarks.push_back(fmt::format(
        "The file has thrusts, at most {} N each, and no speeds of rotors: k_f and speed_max give them.",
        *first.greatest));
  }

  const XmlFile& file_;
  MjcfSettings settings_;
  std::vector<const MjcfElement*> bodies_;
  std::vector<bool> flies_;
  std::map<std::string, PartPose> sites_;
  std::vector<Thrust> thrusts_;
};

}  // namespace

VehicleDescription describe_mjcf(const XmlFile& file) { return MjcfVehicle(file).found; }

}  // namespace sightline
