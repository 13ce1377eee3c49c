/// Potential of a cone-shaped field of view.
#pragma once

#include <cmath>

#include "sightline/model/frames.hpp"
#include "sightline/potential/potential.hpp"
#include "sightline/potential/step.hpp"

namespace sightline {

/// How the limit angle of a cone enters (27).
enum class ConeForm {
  sine,     ///< y^2 + z^2 <= (x sin alpha)^2, as printed: half angle atan(sin alpha), 0.447 rad at 0.5 rad
  tangent,  ///< y^2 + z^2 <= (x tan alpha)^2: the half angle is alpha
};

/// Potential of a cone-shaped field of view: small inside the cone, rising away from it.
///
///   constraints   c1 = y^2 + z^2 - (x sin alpha)^2 <= 0,   c2 = -x <= 0          (27), (28)
///   unit step     l = eps(c2) + eps(c1) eps(-c2)                                 (30)
///   slope         l = eps(c2) (1 + kappa_G (x^2 + y^2 + z^2))
///                   + eps(c1) eps(-c2) (1 + kappa_G (y^2 + z^2))                 (34)
///   sigmoid       eps(c) <- sig(c, kappa_A)                                      (39)
///
/// with (x, y, z) the target in the sensor frame S, x along the optical axis, (48).
struct SensorCone {
  double alpha = 0.5;
  double kappa_G = 0.01;
  double kappa_A = 2.0;
  ConeForm form = ConeForm::sine;
  SensorMount mount{};  ///< of the camera on the observer, (45)

  static constexpr std::string_view name = "sensor_cone";
  static constexpr bool observes = true, keeps_apart = false;
  static constexpr std::string_view limit_unit = "rad";
  static constexpr auto parameters() {
    constexpr std::array<std::string_view, 2> forms = {"sine", "tangent"};
    return std::tuple{
        parameter("alpha", &SensorCone::alpha, "rad", acute_angle, "beam angle"),
        parameter("kappa_G", &SensorCone::kappa_G, "1/m^2", from_zero,
                  "slope outside the cone; 0 leaves no gradient to return by, (33)"),
        parameter("kappa_A", &SensorCone::kappa_A, "1/m^2", above_zero, "sharpness of the step"),
        parameter("form", &SensorCone::form, forms, "the border is at x sin alpha, (27), or x tan alpha")};
  }

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    check_mount(name, mount);
  }

  /// l over any step; UnitStep with kappa_G = 0 is (30).
  /// @param observer  a Sight, or the Pose of an upright robot
  template <class Step, class S, template <class> class Seen>
  S over(const Step& eps, const Seen<S>& observer, const Pose<S>& target) const {
    const Vec3<S> p_S = mount(observer, target.p);
    const double slope = form == ConeForm::sine ? std::sin(alpha) : std::tan(alpha);
    const S off_axis = square(p_S.y) + square(p_S.z);
    const S c1 = off_axis - square(slope) * square(p_S.x);
    const S c2 = -p_S.x;
    return eps(c2) * (1.0 + kappa_G * (square(p_S.x) + off_axis)) +
           eps(c1) * eps(-c2) * (1.0 + kappa_G * off_axis);
  }

  template <class S>
  S operator()(const Sight<S>& observer, const Sight<S>& target) const {
    return over<SigmoidStep, S>({kappa_A}, observer, target);
  }

  /// Angle by which the target is out of view: alpha_t - alpha [rad], (71).
  double violation(const Sight<double>& observer, const Sight<double>& target) const {
    return view_angle(mount, observer, target.p) - alpha;
  }
};

}  // namespace sightline
