/// Cameras, the tags that they detect, and the hulls that occlude tags: parameters and geometry.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/fixed.hpp"
#include "sightline/base/parameter.hpp"
#include "sightline/model/frames.hpp"
#include "sightline/ocp/active_team.hpp"
#include "sightline/world/rigid_body.hpp"

namespace sightline {

/// Content of a detection of a tagged body.
enum class CameraOutput {
  pose,      ///< position and attitude
  position,  ///< position alone, that is bearing and range
};
inline constexpr std::array<std::string_view, 2> camera_outputs = {"pose", "position"};

/// Pinhole camera with a global shutter, without distortion. Its optical axis is x of the sensor
/// frame S.
struct Camera {
  static constexpr std::string_view name = "camera";

  int width = 320, height = 240;
  double field_of_view = 1.0472;
  double rate = 30.0;
  std::array<double, 2> latency = {0.03, 0.08};
  double exposure = 0.008;
  double noise = 4.0;
  double blur = 0.7;
  double dropout = 0.0;
  double outliers = 0.0;
  double flips = 0.0;
  double misalignment = 0.0;
  CameraOutput output = CameraOutput::pose;

  static constexpr Bounds share = {0.0, 1.0, "0 to 1"};
  bool operator==(const Camera&) const = default;

  static constexpr auto parameters() {
    using C = Camera;
    return std::tuple{
        parameter("width", &C::width, "px", {16, 4096, "16 to 4096"}, "of a picture"),
        parameter("height", &C::height, "px", {16, 4096, "16 to 4096"}, "of a picture"),
        parameter("field_of_view", &C::field_of_view, "rad", {0.1, 2.6, "0.1 to 2.6"},
                  "angle that the height covers"),
        parameter("rate", &C::rate, "Hz", {0.1, 1000, "0.1 to 1000"},
                  "pictures; each is taken at the first period that it is due at"),
        parameter("latency", &C::latency, "s", {0, 1, "0 to 1"},
                  "from exposure to arrival: drawn evenly between the two"),
        parameter("exposure", &C::exposure, "s", {0, 0.1, "0 to 0.1"},
                  "while it lasts, what moves is smeared"),
        parameter("noise", &C::noise, "", {0, 64, "0 to 64"}, "of a pixel, of 255 grey levels"),
        parameter("blur", &C::blur, "px", {0, 8, "0 to 8"}, "of the lens, in rendered pictures"),
        parameter("dropout", &C::dropout, "", share, "part of the pictures that is lost"),
        parameter("outliers", &C::outliers, "", share, "part of the detections at another place"),
        parameter("flips", &C::flips, "", share,
                  "part of the detections with a heading off by 0.35 to 1.35 rad"),
        parameter("misalignment", &C::misalignment, "rad", {0, 0.5, "0 to 0.5"},
                  "turn against its mounting, about an axis that is drawn once"),
        parameter("output", &C::output, camera_outputs,
                  "of a body with tags: position and attitude, or where it is alone")};
  }

  /// @throws std::invalid_argument naming a number out of its range
  void check() const;
  /// Focal length f [px].
  double focal() const;
  /// Side of a tag of this size [m] in a picture [px], at this depth [m].
  double pixels(double size, double depth) const { return focal() * size / depth; }
  /// Projection of a point of S, with x > 0, into a picture [px]: right and down from the image
  /// centre.
  Vec2<double> project(const Vec3<double>& p_S) const {
    const double f = focal();
    return {-f * p_S.y / p_S.x, -f * p_S.z / p_S.x};
  }
};

/// AprilTag families.
enum class TagFamily { tag36h11 };
inline constexpr std::array<std::string_view, 1> tag_families = {"tag36h11"};

/// Square tags on upright plates around a body. The first plate faces ahead (x of B); the others
/// follow to the left at equal angles.
struct Tags {
  static constexpr std::string_view name = "tags";

  double size = 0.2;
  int faces = 4;
  double distance = 0.132;
  double height = 0.0;
  TagFamily family = TagFamily::tag36h11;

  static constexpr int faces_max = 8;
  bool operator==(const Tags&) const = default;
  static constexpr double border = 1.25;  ///< side of a tag with its white border, over its size

  static constexpr auto parameters() {
    using T = Tags;
    return std::tuple{parameter("size", &T::size, "m", {1e-3, 10, "0.001 to 10"}, "side of the black square"),
                      parameter("faces", &T::faces, "", {1, faces_max, "1 to 8"},
                                "plates, at equal angles, the first ahead"),
                      parameter("distance", &T::distance, "m", {0, 10, "0 to 10"},
                                "of a plate from the body's origin, level"),
                      parameter("height", &T::height, "m", {-10, 10, "-10 to 10"},
                                "of the plates' middle above that origin"),
                      parameter("family", &T::family, tag_families, "of AprilTag")};
  }

  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
  /// Outward unit normal of a plate, in B.
  Vec3<double> normal(int face) const;
  /// Centre of a tag in B [m].
  Vec3<double> centre(int face) const;
  /// Corners of a tag in B [m], its size multiplied by `scale`. Order, seen from outside: bottom
  /// left, bottom right, top right, top left.
  std::array<Vec3<double>, 4> corners(int face, double scale = 1.0) const;
};

/// Body that occludes others: an upright cylinder about the body's origin, or a sphere at height 0.
struct Hull {
  static constexpr std::string_view name = "hull";

  double radius = 0.2;
  double height = 0.0;

  static constexpr auto parameters() {
    return std::tuple{needed(parameter("radius", &Hull::radius, "m", {1e-3, 100, "0.001 to 100"},
                                       "of the cylinder or the sphere")),
                      parameter("height", &Hull::height, "m", {0, 100, "0 to 100"},
                                "of the cylinder, half of it above the body's origin; 0: a sphere")};
  }

  /// Whether the hull, centred at `at`, intersects the line of sight from a to b. False if a or b
  /// is inside the hull.
  bool hides(const Vec3<double>& at, const Vec3<double>& a, const Vec3<double>& b) const;
};

struct RobotCamera {
  BodyId observer{};
  SensorMount mount{};
  Camera camera{};
  bool render = false;  ///< render pictures and search them for tags; else draw detections
  std::string frame{};  ///< optical frame of a real camera in /tf
};
struct BodyTags {
  BodyId body{};
  Tags tags{};
};
struct BodyHull {
  BodyId body{};
  Hull hull{};
};

/// All cameras, tags and occluding hulls of a team.
struct CameraOptions {
  std::uint64_t seed = 1;
  std::vector<RobotCamera> cameras{};
  std::vector<BodyTags> tags{};
  std::vector<BodyHull> hulls{};
  std::vector<std::vector<std::string>>
      tag_frames{};  ///< frame names in /tf, for each of `tags`, one for each face

  /// Camera of this robot, or tags of this body; nullptr if it has none.
  const RobotCamera* camera_of(BodyId observer) const noexcept;
  const BodyTags* tags_of(BodyId body) const noexcept;
};

/// Position and attitude: of a body in G, or of a detected body in S.
struct RigidPose {
  Vec3<double> p{};
  Rotation R{};
};

/// Pose in G of the sensor frame S on a body. A mount that a gimbal holds level uses the body's
/// heading alone.
RigidPose sensor_pose(const SensorMount& mount, const RigidPose& body);
/// Pose of b in the frame a; both are given in G.
RigidPose seen_from(const RigidPose& a, const RigidPose& b);

}  // namespace sightline
