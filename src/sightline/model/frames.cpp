#include "sightline/model/frames.hpp"

#include <algorithm>
#include <cmath>

namespace sightline {

double view_angle(const SensorMount& mount, const Pose<double>& robot, const Vec3<double>& point) {
  const Vec3<double> p_S = mount(robot, point);
  // atan2 keeps its accuracy near the axis, where acos(x / |p|) loses half the digits.
  return std::atan2(norm(p_S.y, p_S.z), p_S.x);
}

}  // namespace sightline
