/// Potentials of distance and relative velocity whose gradient does not vanish while the limit is
/// violated. docs/equations.md, 13.
#pragma once

#include "sightline/base/elementary.hpp"
#include "sightline/model/frames.hpp"
#include "sightline/potential/potential.hpp"

namespace sightline {

namespace detail {

/// Distance of two positions [m], with a slope of 0.7 where they coincide: there a moves along +x
/// of G, and b along -x. It differs from the true distance by less than 0.02 m.
template <class S>
S distance_with_slope(const Vec3<S>& a, const Vec3<S>& b) {
  constexpr double width = 0.01;
  const Vec3<S> r = a - b;
  return sqrt(square(r.x + width) + square(r.y) + square(r.z) + square(width));
}

}  // namespace detail

/// Pushes two robots apart that are closer than a distance.
///
///   l = softplus(kappa (d_min - D)) / kappa,   softplus(c) = ln(1 + e^c)
///
/// in metres: d_min - D well inside, 0 well outside. The gradient of KeepOut, in contrast, vanishes
/// well inside.
struct TooNear {
  double d_min = 1.0;
  double kappa = 10.0;

  static constexpr std::string_view name = "too_near";
  static constexpr bool keeps_apart = true;
  static constexpr std::string_view limit_unit = "m";
  static constexpr auto parameters() {
    return std::tuple{
        parameter("d_min", &TooNear::d_min, "m", above_zero, "least distance"),
        parameter("kappa", &TooNear::kappa, "1/m", above_zero, "sharpness of the bend at d_min")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this); }

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    return (1.0 / kappa) * softplus(kappa * (d_min - detail::distance_with_slope(a.p, b.p)));
  }

  /// Distance below the limit: d_min - D [m].
  double violation(const Sight<double>& a, const Sight<double>& b) const { return d_min - norm(a.p - b.p); }
};

/// Pulls two robots together that are farther apart than a distance.
///
///   l = softplus(kappa (D - d_max)) / kappa
///
/// in metres: D - d_max well outside, 0 well inside. The gradient of Cohesion, in contrast,
/// vanishes well outside.
struct TooFar {
  double d_max = 2.0;
  double kappa = 10.0;

  static constexpr std::string_view name = "too_far";
  static constexpr bool keeps_apart = false;
  static constexpr std::string_view limit_unit = "m";
  static constexpr auto parameters() {
    return std::tuple{
        parameter("d_max", &TooFar::d_max, "m", above_zero, "greatest distance"),
        parameter("kappa", &TooFar::kappa, "1/m", above_zero, "sharpness of the bend at d_max")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this); }

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    return (1.0 / kappa) * softplus(kappa * (detail::distance_with_slope(a.p, b.p) - d_max));
  }

  /// Distance above the limit: D - d_max [m].
  double violation(const Sight<double>& a, const Sight<double>& b) const { return norm(a.p - b.p) - d_max; }
};

/// Damps the relative velocity of two robots, but not their velocity in G: equal velocities have no
/// cost.
///
///   l = |v_a - v_b|^2 / v_0^2
struct RelativeVelocity {
  double v_0 = 1.0;

  static constexpr std::string_view name = "relative_velocity";
  static constexpr bool keeps_apart = false;
  static constexpr auto parameters() {
    return std::tuple{parameter("v_0", &RelativeVelocity::v_0, "m/s", above_zero, "velocity that costs 1")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this); }

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    const Vec3<S> v = a.v - b.v;
    return (1.0 / square(v_0)) * dot(v, v);
  }
};

}  // namespace sightline
