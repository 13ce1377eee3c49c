#pragma once

#include "sightline/model/frames.hpp"
#include "sightline/potential/potential.hpp"
#include "sightline/potential/step.hpp"

namespace sightline {

/// Keeps two robots apart ("collision avoidance", (49)-(54), with the sign of the step mended).
///
///   c = d_min^2 - D^2 <= 0,   l = sig(c, kappa_A) (kappa_H - kappa_G D^2),   D the distance of the positions
///   [m]
struct KeepOut {
  double d_min = 1.0;      ///< [m], > 0
  double kappa_H = 4.5;    ///< height of the step [-], > 0
  double kappa_G = 0.001;  ///< slope inside [1/m^2], >= 0
  double kappa_A = 3.0;    ///< sharpness of the step [1/m^2], > 0

  static constexpr std::string_view name = "keep_out";

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    require(d_min > 0, name, "d_min", d_min, "> 0 m");
    require(kappa_H > 0, name, "kappa_H", kappa_H, "> 0");
    require(kappa_G >= 0, name, "kappa_G", kappa_G, ">= 0 1/m^2");
    require(kappa_A > 0, name, "kappa_A", kappa_A, "> 0 1/m^2");
  }

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

  /// How much too near: d_min - D [m].
  double violation(const Sight<double>& a, const Sight<double>& b) const { return d_min - norm(a.p - b.p); }
};

/// Keeps two robots together, (55)-(59), with the sign of the step mended.
///
///   c = D^2 - d_max^2 <= 0,   l = sig(c, kappa_A) (kappa_H + kappa_G D^2)
struct Cohesion {
  double d_max = 2.0;      ///< [m], > 0
  double kappa_H = 1.5;    ///< height of the step [-], > 0
  double kappa_G = 0.001;  ///< slope outside [1/m^2], >= 0
  double kappa_A = 3.0;    ///< sharpness of the step [1/m^2], > 0

  static constexpr std::string_view name = "cohesion";

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    require(d_max > 0, name, "d_max", d_max, "> 0 m");
    require(kappa_H > 0, name, "kappa_H", kappa_H, "> 0");
    require(kappa_G >= 0, name, "kappa_G", kappa_G, ">= 0 1/m^2");
    require(kappa_A > 0, name, "kappa_A", kappa_A, "> 0 1/m^2");
  }

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

  /// How much too far: D - d_max [m].
  double violation(const Sight<double>& a, const Sight<double>& b) const { return norm(a.p - b.p) - d_max; }
};

}  // namespace sightline
