#include "bridges/dds/links/flatness.hpp"

namespace sightline::dds {

FlatAttitude flat_attitude(const Vec3<double>& a, const Vec3<double>& j, const Vec2<double>& d,
                           double r) noexcept {
  constexpr double least_lift = 0.1 * gravity;  // smallest a_z + g that defines an attitude [m/s^2]
  const Vec3<double> up = {a.x, a.y, a.z + gravity};
  if (!(up.z > least_lift)) return {upright(d), {0, 0, r}};
  const double lift = norm(up);
  const Vec3<double> z = (1 / lift) * up;
  // Tilt: horizontal over vertical thrust, forward and left of the heading.
  const Vec2<double> l = rotate<double>({d.x, -d.y}, {up.x / up.z, up.y / up.z});
  const Quaternion q = leaning(d, l);
  const Rotation R = rotation(q);
  const Vec3<double> z_rate = (1 / lift) * (j - dot(j, z) * z);
  const Vec3<double> left = {-d.y, d.x, 0};  // of the heading, horizontal
  const double w_x = -dot(z_rate, R.y), w_y = dot(z_rate, R.x);
  const double w_z = (norm(R.x.x, R.x.y) * r + w_y * dot(R.z, left)) / dot(R.y, left);
  return {q, {w_x, w_y, w_z}};
}

}  // namespace sightline::dds
