#include "sightline/model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sightline {

bool all_finite(std::span<const double> values) noexcept {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool normalise_heading(double* d) noexcept {
  const double length = norm(d[0], d[1]);
  constexpr double shortest = 1e-6;  // below this, rounding determines the direction
  if (!(length > shortest) || !std::isfinite(length)) return false;
  d[0] /= length;
  d[1] /= length;
  return true;
}

double wrap_angle(double psi) noexcept {
  const double wrapped = std::remainder(psi, 2 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

}  // namespace sightline
