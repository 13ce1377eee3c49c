#include <algorithm>
#include <numbers>

#include "sightline/vehicle.hpp"

namespace sightline {

Vec3<double> Jet::air(const Vec3<double>& there) const noexcept {
  const Vec3<double> d = there - p;
  const double z = dot(d, down), r2 = dot(d, d) - square(z);
  if (!(z > 0)) return {};
  // Early exit for most points: so far off the axis, less than e^-25 of the speed is left.
  const double grown = square(growth * z);
  if (!(r2 < 25 * (2 * radius2 + grown))) return {};
  const double zeta = z / sqrt(radius2 + square(z));
  const double b2 = 2 * radius2 / (1 + zeta) + grown;
  const double w = sqrt((1 + zeta) * thrust / (std::numbers::pi * air_density * b2));
  return (w * exp(-std::max(r2, 0.0) / b2)) * down;
}

}  // namespace sightline
