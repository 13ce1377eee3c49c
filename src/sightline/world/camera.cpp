#include <algorithm>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/sensors.hpp"

namespace sightline {

void Camera::check() const {
  check_parameters(*this);
  if (latency[0] > latency[1])
    throw_invalid("camera.latency = [{}, {}] s, expected the shortest first", latency[0], latency[1]);
  if ((focal_length[0] > 0) != (focal_length[1] > 0))
    throw_invalid("camera.focal_length = [{}, {}] px, expected both above 0, or neither", focal_length[0],
                  focal_length[1]);
  const bool wide = distortion == Distortion::equidistant;
  if (field_of_view > 2.6 && !wide)
    throw_invalid("camera.field_of_view = {}, expected 0.1 to 2.6 rad, or distortion = \"equidistant\"",
                  field_of_view);
  const std::size_t n = coefficients.size();
  const bool fit = distortion == Distortion::none        ? n == 0
                   : distortion == Distortion::plumb_bob ? n == 4 || n == 5
                                                         : n == (wide ? 4U : 8U);
  if (!fit)
    throw_invalid("camera.coefficients has {} numbers, expected {}", n,
                  distortion == Distortion::none        ? "none without a distortion"
                  : distortion == Distortion::plumb_bob ? "4 or 5 with plumb_bob"
                  : wide                                ? "4 with equidistant"
                                                        : "8 with rational_polynomial");
}

Vec3<double> Tags::normal(int face) const {
  const SinCos<double> d = sincos(2 * std::numbers::pi * face / faces);
  return {d.cos, d.sin, 0};
}

Vec3<double> Tags::centre(int face) const { return distance * normal(face) + Vec3<double>{0, 0, height}; }

std::array<Vec3<double>, 4> Tags::corners(int face, double scale) const {
  const double half = 0.5 * scale * size;
  const Vec3<double> n = normal(face), c = centre(face), right = half * Vec3<double>{-n.y, n.x, 0},
                     up = {0, 0, half};
  return {c - right - up, c + right - up, c + right + up, c - right + up};
}

bool Hull::hides(const Vec3<double>& at, const Vec3<double>& a, const Vec3<double>& b) const {
  const Vec3<double> from = a - at, way = b - a;
  const bool is_sphere = !(height > 0);
  const auto across = [&](const Vec3<double>& v, const Vec3<double>& w) {
    return v.x * w.x + v.y * w.y + (is_sphere ? v.z * w.z : 0.0);
  };
  const auto within = [&](const Vec3<double>& p) {
    return across(p, p) < square(radius) && (is_sphere || std::abs(p.z) < 0.5 * height);
  };
  if (within(from) || within(b - at)) return false;
  // Section of the line of sight within the lateral surface: 0 <= low <= s <= high <= 1.
  double low = 0.0, high = 1.0;
  const double ww = across(way, way), fw = across(from, way), rest = across(from, from) - square(radius);
  if (ww > 0) {
    const double root = square(fw) - ww * rest;
    if (!(root > 0)) return false;
    low = std::max(low, (-fw - sqrt(root)) / ww);
    high = std::min(high, (-fw + sqrt(root)) / ww);
  } else if (rest >= 0) {
    return false;
  }
  if (is_sphere || !(low < high)) return low < high;
  const double half = 0.5 * height;
  if (way.z == 0) return std::abs(from.z) < half;
  const double one = (-half - from.z) / way.z, other = (half - from.z) / way.z;
  return std::max(low, std::min(one, other)) < std::min(high, std::max(one, other));
}

RigidPose sensor_pose(const SensorMount& mount, const RigidPose& body) {
  Rotation R = body.R;
  if (mount.frame == MountFrame::level) {
    const Vec2<double> d = heading(body.R);
    R = {{d.x, d.y, 0}, {-d.y, d.x, 0}, {0, 0, 1}};
  }
  return {body.p + R.to_G(mount.offset), compose(R, rotation_from(mount.attitude()))};
}

RigidPose seen_from(const RigidPose& a, const RigidPose& b) {
  return {a.R.to_B(b.p - a.p), between(a.R, b.R)};
}

const RobotCamera* CameraOptions::camera_of(BodyId observer) const noexcept {
  return camera_of(observer, nullptr);
}

const RobotCamera* CameraOptions::camera_of(BodyId observer, const SensorMount* mount) const noexcept {
  const auto found = std::find_if(cameras.begin(), cameras.end(), [&](const RobotCamera& one) {
    return one.observer == observer && (mount == nullptr || one.mount == *mount);
  });
  return found != cameras.end() ? &*found : nullptr;
}

const BodyTags* CameraOptions::tags_of(BodyId body) const noexcept {
  const auto found =
      std::find_if(tags.begin(), tags.end(), [&](const BodyTags& one) { return one.body == body; });
  return found != tags.end() ? &*found : nullptr;
}

}  // namespace sightline
