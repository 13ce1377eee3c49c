#include "sightline/world/sighting.hpp"

namespace sightline {

Measurement sighting_of(const Detection& detection, const SensorMount& mount,
                        const Vec2<double>& roll_pitch) noexcept {
  const auto covariance = [&](int i, int j) {
    return detection.covariance[Detection::place(static_cast<std::size_t>(i), static_cast<std::size_t>(j))];
  };
  Measurement z{.stamp = detection.stamp, .source = detection.target.index, .z = detection.p};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) z.R(i, j) = covariance(i, j);
  z.has_yaw = detection.is_oriented();
  if (!z.has_yaw) return z;
  const Mat<3, 3> level = mount.frame == MountFrame::body ? tilt(roll_pitch.x, roll_pitch.y) : identity<3>();
  const Mat<3, 3> R_VS = level * mount.attitude(), R_VT = R_VS * matrix(rotation(detection.q));
  z.yaw = yaw_of(R_VT);
  const Vec3<double> x = {R_VT(0, 0), R_VT(1, 0), R_VT(2, 0)};
  const double per = 1 / (square(x.x) + square(x.y));
  const Vec3<double> g = transposed(R_VS) * Vec3<double>{-per * x.z * x.x, -per * x.z * x.y, 1.0};
  const double g_S[3] = {g.x, g.y, g.z};
  double cross[3] = {0, 0, 0};
  z.yaw_variance = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      z.yaw_variance += g_S[i] * covariance(3 + i, 3 + j) * g_S[j];
      cross[i] += covariance(i, 3 + j) * g_S[j];
    }
  z.R_yaw = {cross[0], cross[1], cross[2]};
  return z;
}

}  // namespace sightline
