#include <algorithm>
#include <numbers>

#include "sightline/vehicle.hpp"

namespace sightline {

Vec3<double> Jet::air(const Vec3<double>& there) const noexcept {
  const Vec3<double> below = there - p;
  const double z = dot(below, down);
  if (!(z > 0)) return {};
  const double zeta = z / sqrt(radius2 + square(z));
  const double b2 = 2 * radius2 / (1 + zeta) + square(growth * z);
  const double w = sqrt((1 + zeta) * thrust / (std::numbers::pi * air_density * b2));
  // From the place where the disc was when this air left it.
  const Vec3<double> d = below + (z / w) * v;
  const double r2 = dot(d, d) - square(dot(d, down));
  // So far off the axis, less than e^-25 of the speed is left. Not a number, without thrust, is refused too.
  if (!(r2 < 25 * b2)) return {};
  return (w * exp(-std::max(r2, 0.0) / b2)) * down;
}

}  // namespace sightline
