/// Cameras of robots, the tags that they look for, and the hulls that hide them: numbers, and where they are on a body.
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

/// What a camera tells of a body with tags.
enum class CameraOutput {
  pose,      ///< position and attitude
  position,  ///< position alone, that is bearing and range
};
inline constexpr std::array<std::string_view, 2> camera_outputs = {"pose", "position"};

/// A pinhole camera with a global shutter, without distortion, that looks along x of the sensor frame S.
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
  /// f [px].
  double focal() const;
  /// The side of a tag in a picture [px], at this depth [m].
  double pixels(double size, double depth) const { return focal() * size / depth; }
  /// Where a point of S is in a picture [px]: to the right and down, from the middle.
  Vec2<double> project(const Vec3<double>& p_S) const {
    const double f = focal();
    return {-f * p_S.y / p_S.x, -f * p_S.z / p_S.x};
  }
};

/// Families of AprilTag.
enum class TagFamily { tag36h11 };
inline constexpr std::array<std::string_view, 1> tag_families = {"tag36h11"};

/// Square tags on upright plates around a body, the first ahead (x of B), the next ones to the left at equal angles.
struct Tags {
  static constexpr std::string_view name = "tags";

  double size = 0.2;
  int faces = 4;
  double distance = 0.132;
  double height = 0.0;
  TagFamily family = TagFamily::tag36h11;

  static constexpr int faces_max = 8;
  bool operator==(const Tags&) const = default;
  static constexpr double border =
      1.25;  ///< side of a tag with the white that it needs around it, over its size

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
  /// Out of the plate, in B.
  Vec3<double> normal(int face) const;
  /// The middle of a tag in B [m].
  Vec3<double> centre(int face) const;
  /// Corners of a tag in B [m], as seen from outside: bottom left, bottom right, top right, top left; `scale` of its size.
  std::array<Vec3<double>, 4> corners(int face, double scale = 1.0) const;
};

/// What hides others: an upright cylinder about a body's origin, a sphere where it has no height.
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

  /// Whether the way from a to b passes through it, at this place; not where one of them is within it.
  bool hides(const Vec3<double>& at, const Vec3<double>& a, const Vec3<double>& b) const;
};

struct RobotCamera {
  BodyId observer{};
  SensorMount mount{};
  Camera camera{};
  bool render = false;  ///< pictures are rendered, and searched for tags; else detections are drawn
  std::string frame{};  ///< what /tf calls its optical frame, where it is a real one
};
struct BodyTags {
  BodyId body{};
  Tags tags{};
};
struct BodyHull {
  BodyId body{};
  Hull hull{};
};

/// All that is seen by, seen and in the way.
struct CameraOptions {
  std::uint64_t seed = 1;
  std::vector<RobotCamera> cameras{};
  std::vector<BodyTags> tags{};
  std::vector<BodyHull> hulls{};
  std::vector<std::vector<std::string>>
      tag_frames{};  ///< of each of `tags`, face by face: what /tf calls them

  /// Of that robot or body; nullptr where it has none.
  const RobotCamera* camera_of(BodyId observer) const noexcept;
  const BodyTags* tags_of(BodyId body) const noexcept;
};

/// A pose: of a body in G, or of one seen from S.
struct RigidPose {
  Vec3<double> p{};
  Rotation R{};
};

/// The frame S of a sensor on a body; of a mount that a gimbal holds level, the body's heading alone counts.
RigidPose sensor_pose(const SensorMount& mount, const RigidPose& body);
/// b in the frame a, both given in G.
RigidPose seen_from(const RigidPose& a, const RigidPose& b);

}  // namespace sightline
