/// Potential that turns a sensor towards a target.
#pragma once

#include <cmath>

#include "sightline/model/frames.hpp"
#include "sightline/potential/potential.hpp"

namespace sightline {

/// Turns the sensor towards the target from any initial direction: 1 minus the cosine of the angle
/// gamma between the sensor axis and the target. docs/equations.md, 13.
///
///   l = 1 - (cos beta (x cos omega + y sin omega) - sin beta z) / sqrt(x^2 + y^2 + z^2 + width^2)
///
/// with (x, y, z) the target relative to the sensor in the frame that the mount is fixed to, V or B
/// (x ahead, y left, z up), and beta the pitch of the mount. l is in [0, 2]; it is 1 - cos gamma
/// for omega = 0 and a target much farther than `width`.
///
/// With the target straight behind, l would be stationary and the robot would not turn. So, with
/// phi the horizontal angle from the nose to the target, the axis is rotated to the left by
///
///   omega = tilt sig(-0.906 - cos phi, 40),   cos phi = x / sqrt(x^2 + y^2 + width^2)
///
/// which is 0.96 to 0.98 of `tilt` for |phi| above 170 degrees, and less than 1e-6 rad for |phi|
/// below 123 degrees. With the default, the robot turns left from 170 to 189 degrees.
struct Bearing {
  double alpha = 0.5;
  double width = 0.1;
  double tilt = 0.2;
  SensorMount mount{};  ///< of the camera on the observer, (45)

  static constexpr std::string_view name = "bearing";
  static constexpr bool observes = true, keeps_apart = false;
  static constexpr std::string_view limit_unit = "rad";
  static constexpr auto parameters() {
    constexpr Bounds small = {0.0, 0.2, "in [0, 0.2]"},
                     half = {std::numeric_limits<double>::min(), 3.1416, "in (0, pi]"};
    return std::tuple{
        parameter("alpha", &Bearing::alpha, "rad", half, "angle up to which the target counts as in view"),
        parameter("width", &Bearing::width, "m", above_zero, "nearer than this to the sensor l is smoothed"),
        parameter("tilt", &Bearing::tilt, "rad", small, "to the left, of the axis with the target behind")};
  }

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    check_mount(name, mount);
  }

  template <class S>
  S operator()(const Sight<S>& observer, const Sight<S>& target) const {
    const SensorMount straight = {.pitch = 0.0, .offset = mount.offset, .frame = mount.frame};
    const Vec3<S> p_V = straight(observer, target.p);
    const S level = square(p_V.x) + square(p_V.y) + square(width);
    const S omega = tilt * logistic(-40.0 * (0.906 + p_V.x * (1.0 / sqrt(level))));
    const S ahead = p_V.x * cos(omega) + p_V.y * sin(omega);
    return 1.0 - (cos(mount.pitch) * ahead - sin(mount.pitch) * p_V.z) * (1.0 / sqrt(level + square(p_V.z)));
  }

  /// Angle by which the target is out of view: alpha_t - alpha [rad], (71).
  double violation(const Sight<double>& observer, const Sight<double>& target) const {
    return view_angle(mount, observer, target.p) - alpha;
  }
};

}  // namespace sightline
