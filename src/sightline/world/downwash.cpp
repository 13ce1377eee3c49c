#include <algorithm>
#include <numbers>

#include "sightline/vehicle.hpp"

namespace sightline {

Vec3<double> Jet::air(const Vec3<double>& there) const noexcept {
  const Vec3<double> below = there - p;
  const double z = dot(below, down);
  if (!(z > 0)) return {};
  const double grown = square(growth * z), wide = 2 * radius2 + grown;
  constexpr double pi_rho = std::numbers::pi * air_density;
  // Early exit for most points: too far aside, wherever the air may trail. w^2 is at least thrust / (pi_rho wide).
  const double aside2 = dot(below, below) - square(z);
  if (!(aside2 * thrust < 2 * wide * (25 * thrust + pi_rho * square(z) * dot(v, v)))) return {};
  const double zeta = z / sqrt(radius2 + square(z));
  const double b2 = 2 * radius2 / (1 + zeta) + grown;
  const double w = sqrt((1 + zeta) * thrust / (pi_rho * b2));
  // From the place where the disc was when this air left it.
  const Vec3<double> d = below + (z / w) * v;
  const double r2 = dot(d, d) - square(dot(d, down));
  // So far off the axis, less than e^-25 of the speed is left. Without thrust r2 is not a number.
  if (!(r2 < 25 * b2)) return {};
  return (w * exp(-std::max(r2, 0.0) / b2)) * down;
}

}  // namespace sightline
