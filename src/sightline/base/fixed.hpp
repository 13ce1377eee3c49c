/// Small vectors over any scalar: double, a lane pack, or the recording scalar.
#pragma once

#include "sightline/base/elementary.hpp"

namespace sightline {

/// A heading d = (d_x, d_y) = (cos psi, sin psi), (18), (19); or any vector in the plane.
template <class S>
struct Vec2 {
  S x{}, y{};
};

/// A vector with three components: a position [m] or a velocity [m/s].
template <class S>
struct Vec3 {
  S x{}, y{}, z{};

  friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vec3 operator*(const S& s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }
};

template <class S>
S dot(const Vec2<S>& a, const Vec2<S>& b) {
  return a.x * b.x + a.y * b.y;
}

template <class S>
S dot(const Vec3<S>& a, const Vec3<S>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class S>
S norm(const Vec3<S>& a) {
  return sqrt(dot(a, a));
}

/// sqrt(x^2 + y^2), within 1 ulp if the squares are normal: for lengths from 1e-150 to 1e150.
/// Beyond, it is 0 or infinite, because it does not scale. std::hypot scales, but its bits differ
/// between machines.
template <Real L>
L norm(L x, L y) {
  return sqrt(fma(x, x, y * y));
}

}  // namespace sightline
