/// Random numbers, poses and sights; every test seeds its own.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>

#include "sightline/model.hpp"

namespace sightline {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Any finite double, every exponent alike.
inline double random_finite(Random& random) {
  for (;;) {
    const double x = std::bit_cast<double>(std::uint64_t{random()});
    if (std::isfinite(x)) return x;
  }
}

template <std::size_t n>
std::array<double, n> uniform_array(Random& random, double low, double high) {
  std::array<double, n> a;
  for (double& v : a) v = uniform(random, low, high);
  return a;
}

inline Vec3<double> random_point(Random& random, double reach) {
  return {uniform(random, -reach, reach), uniform(random, -reach, reach), uniform(random, -reach, reach)};
}

/// Anywhere within `reach` [m] of the origin in each axis, with any heading.
inline Pose<double> random_pose(Random& random, double reach) {
  const double psi = uniform(random, -std::numbers::pi, std::numbers::pi);
  return {random_point(random, reach), {std::cos(psi), std::sin(psi)}};
}

inline Sight<double> random_sight(Random& random, double reach) {
  Sight<double> seen = {random_pose(random, reach), random_point(random, 2.0)};
  seen.lean = {uniform(random, -0.8, 0.8), uniform(random, -0.8, 0.8)};
  return seen;
}

/// A sensor anywhere on the robot that looks anywhere; every second one sits and looks ahead, as
/// the paper's.
inline SensorMount random_mount(Random& random, MountFrame frame = MountFrame::level) {
  SensorMount mount = {
      .pitch = uniform(random, -1.5, 1.5), .offset = uniform(random, -0.5, 0.5), .frame = frame};
  if (random() % 2 == 0) return mount;
  mount.yaw = uniform(random, -3.1, 3.1), mount.roll = uniform(random, -3.1, 3.1);
  mount.offset.y = uniform(random, -0.5, 0.5), mount.offset.z = uniform(random, -0.5, 0.5);
  return mount;
}

/// D [m] apart in a random direction.
inline std::pair<Sight<double>, Sight<double>> random_sights_apart(double D, Random& random) {
  const Sight<double> a = random_sight(random, 3);
  Sight<double> b = random_sight(random, 3);
  const Vec3<double> r = b.p - a.p;
  b.p = a.p + (D / norm(r)) * r;
  return {a, b};
}

}  // namespace sightline
