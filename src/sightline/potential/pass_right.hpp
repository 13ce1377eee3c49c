/// Keeps passing robots apart, each on its right, so that head-on encounters end in no deadlock.
/// docs/equations.md, 14.
#pragma once

#include "sightline/potential/slope.hpp"

namespace sightline {

/// Pushes two robots apart as TooNear does, with each robot's position shifted to its left.
///
///   l = softplus(kappa (d_min - D_e)) / kappa
///   D_e = |p_a - p_b - (delta/2) J (d_a - d_b)|,   J (x, y) = (-y, x)
///
/// J d points to the left of a robot with heading d. Head on, each robot is pushed to its right. At
/// crossing paths, the robot from the right is slowed down less. For robots with equal headings l
/// equals that of TooNear. They pass at d_min - delta on the right and at d_min + delta on the
/// left.
///
/// Note: the heading is taken as the direction of travel, so the heading needs a reference.
struct PassRight {
  double d_min = 1.0;
  double delta = 0.2;
  double kappa = 10.0;

  static constexpr std::string_view name = "pass_right";
  static constexpr bool keeps_apart = true;
  static constexpr std::string_view limit_unit = "m";
  static constexpr auto parameters() {
    return std::tuple{
        parameter("d_min", &PassRight::d_min, "m", above_zero, "least distance, but for delta"),
        parameter("delta", &PassRight::delta, "m", from_zero,
                  "how far to its left each has the other, below d_min; 0: as too_near"),
        parameter("kappa", &PassRight::kappa, "1/m", above_zero, "sharpness of the bend at d_min")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    require(delta < d_min, name, "delta", delta, "0 m to below d_min");
  }

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    const Vec3<S> none = {S(0.0), S(0.0), S(0.0)};
    return (1.0 / kappa) * softplus(kappa * (d_min - detail::distance_with_slope(moved(a, b), none)));
  }

  /// Distance below the limit: d_min - D_e [m].
  double violation(const Sight<double>& a, const Sight<double>& b) const { return d_min - norm(moved(a, b)); }

 private:
  template <class S>
  Vec3<S> moved(const Sight<S>& a, const Sight<S>& b) const {
    const Vec3<S> r = a.p - b.p;
    const double half = 0.5 * delta;
    return {r.x + half * (a.d.y - b.d.y), r.y - half * (a.d.x - b.d.x), r.z};
  }
};

}  // namespace sightline
