#include "sightline/potential/reference.hpp"

#include <algorithm>
#include <cmath>

namespace sightline {
namespace {

/// Index of the last time <= t; 0 before the first.
std::size_t last_before(const std::vector<double>& times, double t) {
  const auto after = std::upper_bound(times.begin(), times.end(), t);
  return after == times.begin() ? 0 : static_cast<std::size_t>(after - times.begin() - 1);
}

Vec2<double> direction(const std::vector<double>& heading, std::size_t i) {
  if (heading.empty()) return {};
  return {cos(heading[i]), sin(heading[i])};
}

}  // namespace

Pose<double> Circle::operator()(double t) const {
  const auto [s, c] = sincos(rate * t);
  return {{centre.x + radius * c, centre.y + radius * s, centre.z}, {}};
}

Pose<double> Waypoints::operator()(double t) const {
  const std::size_t i = last_before(times, t);
  if (i + 1 >= times.size() || t <= times[i]) return {p[i], direction(heading, i)};
  const double s = (t - times[i]) / (times[i + 1] - times[i]);
  const Vec3<double> at = p[i] + s * (p[i + 1] - p[i]);
  if (heading.empty()) return {at, {}};
  const double turn = wrap_angle(heading[i + 1] - heading[i]);
  return {at, {cos(heading[i] + s * turn), sin(heading[i] + s * turn)}};
}

Pose<double> Steps::operator()(double t) const {
  const std::size_t i = last_before(times, t);
  return {p[i], direction(heading, i)};
}

}  // namespace sightline
