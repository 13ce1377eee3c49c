/// Potentials that limit the distance of two robots, by a sigmoid step.
#pragma once

#include "sightline/model/frames.hpp"
#include "sightline/potential/potential.hpp"
#include "sightline/potential/step.hpp"

namespace sightline {

/// Keeps two robots apart ("collision avoidance", (49)-(54), with the sign of the step corrected).
///
///   c = d_min^2 - D^2 <= 0,   l = sig(c, kappa_A) (kappa_H - kappa_G D^2)
///
/// with D the distance of the positions [m].
struct KeepOut {
  double d_min = 1.0;
  double kappa_H = 4.5;
  double kappa_G = 0.001;
  double kappa_A = 3.0;

  static constexpr std::string_view name = "keep_out";
  static constexpr bool keeps_apart = true;
  static constexpr std::string_view limit_unit = "m";
  static constexpr auto parameters() {
    return std::tuple{parameter("d_min", &KeepOut::d_min, "m", above_zero, "least distance"),
                      parameter("kappa_H", &KeepOut::kappa_H, "", above_zero, "height of the step"),
                      parameter("kappa_G", &KeepOut::kappa_G, "1/m^2", from_zero, "slope inside"),
                      parameter("kappa_A", &KeepOut::kappa_A, "1/m^2", above_zero, "sharpness of the step")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this); }

  template <class Step, class S>
  S over(const Step& eps, const Pose<S>& a, const Pose<S>& b) const {
    const Vec3<S> r = a.p - b.p;
    const S D2 = dot(r, r);
    return eps(square(d_min) - D2) * (kappa_H - kappa_G * D2);
  }

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    return over<SigmoidStep, S>({kappa_A}, a, b);
  }

  /// Distance below the limit: d_min - D [m].
  double violation(const Sight<double>& a, const Sight<double>& b) const { return d_min - norm(a.p - b.p); }
};

/// Keeps two robots together, (55)-(59), with the sign of the step corrected.
///
///   c = D^2 - d_max^2 <= 0,   l = sig(c, kappa_A) (kappa_H + kappa_G D^2)
struct Cohesion {
  double d_max = 2.0;
  double kappa_H = 1.5;
  double kappa_G = 0.001;
  double kappa_A = 3.0;

  static constexpr std::string_view name = "cohesion";
  static constexpr bool keeps_apart = false;
  static constexpr std::string_view limit_unit = "m";
  static constexpr auto parameters() {
    return std::tuple{parameter("d_max", &Cohesion::d_max, "m", above_zero, "greatest distance"),
                      parameter("kappa_H", &Cohesion::kappa_H, "", above_zero, "height of the step"),
                      parameter("kappa_G", &Cohesion::kappa_G, "1/m^2", from_zero, "slope outside"),
                      parameter("kappa_A", &Cohesion::kappa_A, "1/m^2", above_zero, "sharpness of the step")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this); }

  template <class Step, class S>
  S over(const Step& eps, const Pose<S>& a, const Pose<S>& b) const {
    const Vec3<S> r = a.p - b.p;
    const S D2 = dot(r, r);
    return eps(D2 - square(d_max)) * (kappa_H + kappa_G * D2);
  }

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    return over<SigmoidStep, S>({kappa_A}, a, b);
  }

  /// Distance above the limit: D - d_max [m].
  double violation(const Sight<double>& a, const Sight<double>& b) const { return norm(a.p - b.p) - d_max; }
};

}  // namespace sightline
