/// Position bounds of a single robot, derived by the workflow of section 5.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/model/frames.hpp"
#include "sightline/potential/potential.hpp"
#include "sightline/potential/step.hpp"

namespace sightline {

namespace detail {

/// One side of a bound: a step with a slope that leads back inside.
/// @param outside  distance beyond the bound [m]
template <class Step, class S>
S beyond(const Step& eps, double kappa_G, const S& outside) {
  return eps(outside) * (1.0 + kappa_G * square(outside));
}

}  // namespace detail

/// Keeps a robot between two heights.
///
///   l = sig(z - z_max, kappa_A) (1 + kappa_G (z - z_max)^2)
///     + sig(z_min - z, kappa_A) (1 + kappa_G (z_min - z)^2)
struct AltitudeBand {
  double z_min = 0.3;
  double z_max = 3.0;
  double kappa_G = 0.1;
  double kappa_A = 10.0;

  static constexpr std::string_view name = "altitude_band";
  static constexpr std::string_view limit_unit = "m";
  static constexpr auto parameters() {
    return std::tuple{
        parameter("z_min", &AltitudeBand::z_min, "m", any_finite, "least height"),
        parameter("z_max", &AltitudeBand::z_max, "m", any_finite, "greatest height, above z_min"),
        parameter("kappa_G", &AltitudeBand::kappa_G, "1/m^2", from_zero, "slope outside"),
        parameter("kappa_A", &AltitudeBand::kappa_A, "1/m", above_zero, "sharpness of the step")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    require(z_max > z_min, name, "z_max", z_max, "above z_min");
  }

  template <class Step, class S>
  S over(const Step& eps, const Pose<S>& robot) const {
    const S& z = robot.p.z;
    return detail::beyond(eps, kappa_G, S(z - z_max)) + detail::beyond(eps, kappa_G, S(z_min - z));
  }

  template <class S>
  S operator()(const Sight<S>& robot) const {
    return over<SigmoidStep, S>({kappa_A}, robot);
  }

  /// Distance outside the band [m].
  double violation(const Sight<double>& robot) const {
    return std::max(robot.p.z - z_max, z_min - robot.p.z);
  }
};

/// Keeps a robot within a box of G: the sum over the six sides, each in the form of AltitudeBand.
struct Geofence {
  std::array<double, 3> low = {-10.0, -10.0, 0.0};
  std::array<double, 3> high = {10.0, 10.0, 5.0};
  double kappa_G = 0.1;
  double kappa_A = 10.0;

  static constexpr std::string_view name = "geofence";
  static constexpr std::string_view limit_unit = "m";
  static constexpr auto parameters() {
    return std::tuple{
        parameter("low", &Geofence::low, "m", any_finite, "corner"),
        parameter("high", &Geofence::high, "m", any_finite, "opposite corner, above low in each axis"),
        parameter("kappa_G", &Geofence::kappa_G, "1/m^2", from_zero, "slope outside"),
        parameter("kappa_A", &Geofence::kappa_A, "1/m", above_zero, "sharpness of the step")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    for (std::size_t i = 0; i < 3; ++i)
      require(high[i] > low[i], name, "high", high[i], "above low in each axis");
  }

  template <class Step, class S>
  S over(const Step& eps, const Pose<S>& robot) const {
    const std::array<S, 3> p = {robot.p.x, robot.p.y, robot.p.z};
    S l = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      l = l + detail::beyond(eps, kappa_G, S(p[i] - high[i])) +
          detail::beyond(eps, kappa_G, S(low[i] - p[i]));
    }
    return l;
  }

  template <class S>
  S operator()(const Sight<S>& robot) const {
    return over<SigmoidStep, S>({kappa_A}, robot);
  }

  /// Distance outside the box, largest over the axes [m].
  double violation(const Sight<double>& robot) const {
    const std::array<double, 3> p = {robot.p.x, robot.p.y, robot.p.z};
    double worst = p[0] - high[0];
    for (std::size_t i = 0; i < 3; ++i) worst = std::max({worst, p[i] - high[i], low[i] - p[i]});
    return worst;
  }
};

}  // namespace sightline
