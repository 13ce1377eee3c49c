/// What the description of a multirotor by another program (SDF, URDF, MJCF) has of a vehicle.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/import/xml_file.hpp"

namespace sightline {

/// Pose of a part in the frame of its parent, or of the model.
struct PartPose {
  Vec3<double> p{};  ///< [m]
  Mat<3, 3> R = identity<3>();

  friend PartPose operator*(const PartPose& a, const PartPose& b) { return {a.p + a.R * b.p, a.R * b.R}; }
};

/// A rigid part of a model.
struct RigidPart {
  double m = 0.0;    ///< [kg], >= 0
  Vec3<double> p{};  ///< centre of mass in the model [m]
  Mat<3, 3> I{};     ///< about that centre, in the axes of the model [kg m^2]
};

struct DescribedRotor {
  Vec3<double> p{};   ///< in the model [m]
  double spin = 0.0;  ///< 1 anticlockwise seen from above, -1 clockwise; 0: not in the file
};

/// Numbers that a file lacks are empty. Those of rotors are the same for all.
struct VehicleDescription {
  std::vector<RigidPart> parts{};
  std::vector<DescribedRotor> rotors{};
  std::optional<double> k_f{}, k_m{}, speed_max{}, tau_up{}, tau_down{}, rotor_drag{};  ///< as in Vehicle
  std::optional<double> rotor_radius{}, radius{}, height{};
  std::vector<std::string> remarks{};  ///< lines about numbers above, for the result
  std::vector<std::string> notes{};    ///< sentences about what has no counterpart
};

/// Greatest number of parts, and of rotors, of a file.
inline constexpr std::size_t described_parts_max = 256;

/// Moments of inertia by the attributes or elements ixx to izz of SDF and URDF.
/// @param of  the number of a name; the products are optional
template <class Of>
Mat<3, 3> moments(Of&& of) {
  Mat<3, 3> I;
  I(0, 0) = of("ixx"), I(1, 1) = of("iyy"), I(2, 2) = of("izz");
  I(0, 1) = I(1, 0) = of("ixy"), I(0, 2) = I(2, 0) = of("ixz"), I(1, 2) = I(2, 1) = of("iyz");
  return I;
}

/// A plugin with <motorConstant> (MulticopterMotorModel) adds its rotor.
/// @param links  their poses in the model
/// @param joints  the links that joints carry
/// @throws ScenarioError for a motor without a link, that thrusts along another axis than z of the
///   model, or with other constants than the motors before
void add_motor(VehicleDescription& to, const XmlFile& file, const XmlFile::Element& plugin,
               const std::map<std::string, PartPose>& links,
               const std::map<std::string, std::string>& joints);

/// The table [agent.NAME.vehicle]. A comment in it names what the file lacks.
/// @throws ScenarioError for a vehicle without mass, with moments of inertia that are not finite and
///   > 0, or that cannot fly although the file has all of it
Imported vehicle_table(const VehicleDescription& found, const XmlFile& file, const ImportOptions& options);

// Each takes the files of one model, its own and, of SDF, those that it includes.
// @throws ScenarioError for what has no meaning for us

VehicleDescription describe_sdf(std::span<const std::unique_ptr<XmlFile>> files);
VehicleDescription describe_urdf(const XmlFile& file);
VehicleDescription describe_mjcf(const XmlFile& file);

}  // namespace sightline
