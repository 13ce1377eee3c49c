/// The library's potentials and limits: fields of view, distances, regions as text, bounds.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/model.hpp"
#include "sightline/potential.hpp"

namespace sightline {

// Limits the heading error of a reference in a plan to 120 degrees from the robot's heading.
//
// The cost of a heading vector is 2 q (1 - cos e), e the angle from the robot's heading to the
// reference's. Its slope 2 q sin e is zero at 180 degrees, so a plan that starts there would stay
// there. The solver therefore receives a reference that is rotated towards the robot's heading
// until |e| is 120 degrees. Smaller errors are unchanged, bit for bit. As the robot turns, the
// rotated reference moves ahead of it. docs/equations.md, 6.
//
//   d*_seen = R(delta) d*,   delta = e_seen - e,   e_seen = e           for |e| <= 120 degrees
//                                                  e_seen = 120         for e > 120 and e < -175
//                                                  e_seen = -120        for -175 <= e < -120
//
// From 120 to 185 degrees the robot turns left, so that rounding and noise do not choose the side
// at 180. At 185 degrees both directions lead away from that angle, so the side is chosen once.
// Along the horizon delta keeps its value of the first stage, and a moving reference keeps moving.
// If the reference itself jumps by more than 120 degrees, it is placed 120 degrees from its
// previous rotated value.

class Model;

/// Angle from one heading to another, positive to the left, in (-175, 185] degrees [rad]. The range
/// includes 180 degrees and a margin for rounding and noise on the left side.
double heading_error(const Vec2<double>& from, const Vec2<double>& to) noexcept;

/// Heading error limit of one robot. It has no effect unless the states include a heading vector
/// with a weight.
class HeadingErrorLimit {
 public:
  /// Allocates: call only during set-up.
  /// @param Q, Q_f  weights of the states (nx); Q_f may be empty: 0
  HeadingErrorLimit(const Model& model, std::span<const double> Q, std::span<const double> Q_f);

  /// Whether the states include a heading vector with a weight.
  bool applies() const noexcept { return at_[0] >= 0; }

  /// Whether the reference of one stage exceeds the limit; false if a number is not finite or a
  /// heading is (0, 0).
  /// @param x      the robot's state; entry i at x[i entry]
  /// @param x_ref  likewise
  bool exceeded(const double* x, const double* x_ref, std::ptrdiff_t entry) const noexcept;

  /// Rotates the headings of a reference along the horizon, in place; their lengths stay.
  /// @param x      the robot's present state; entry i at x[i x_entry]
  /// @param x_ref  the reference; entry i of stage k, k = 0 .. n - 1, at x_ref[k stage + i entry]
  /// @return whether any heading was rotated
  bool operator()(const double* x, std::ptrdiff_t x_entry, double* x_ref, int n, std::ptrdiff_t stage,
                  std::ptrdiff_t entry) const noexcept;

 private:
  Vec2<double> heading(const double* x, std::ptrdiff_t entry) const noexcept {
    return {x[at_[0] * entry], x[at_[1] * entry]};
  }

  std::array<std::ptrdiff_t, 2> at_;  // indices of the heading in the state; -1: none
};

// Potential that turns a sensor towards a target.

/// Turns the sensor towards the target from any initial direction: 1 minus the cosine of the angle
/// gamma between the sensor axis and the target. docs/equations.md, 13.
///
///   l = 1 - (cos beta (x cos omega + y sin omega) - sin beta z) / sqrt(x^2 + y^2 + z^2 + width^2)
///
/// with (x, y, z) the target relative to the sensor in the frame that the mount is fixed to, V or B,
/// turned by its yaw (x ahead of the sensor, y left, z up), and beta its pitch. l is in [0, 2]; it
/// is 1 - cos gamma for omega = 0 and a target much farther than `width`.
///
/// With the target straight behind, l would be stationary and the robot would not turn. So, with
/// phi the horizontal angle from x to the target, the axis is rotated to the left by
///
///   omega = tilt sig(-0.906 - cos phi, 40),   cos phi = x / sqrt(x^2 + y^2 + width^2)
///
/// which is 0.96 to 0.98 of `tilt` for |phi| above 170 degrees, and less than 1e-6 rad for |phi|
/// below 123 degrees. With the default, the robot turns left from 170 to 189 degrees.
struct Bearing {
  double alpha = 0.5;
  double width = 0.1;
  double tilt = 0.2;
  SensorMount mount{};  ///< of the camera on the observer, (45)

  static constexpr std::string_view name = "bearing";
  static constexpr bool observes = true, keeps_apart = false;
  static constexpr std::string_view limit_unit = "rad";
  static constexpr auto parameters() {
    constexpr Bounds small = {0.0, 0.2, "in [0, 0.2]"},
                     half = {std::numeric_limits<double>::min(), 3.1416, "in (0, pi]"};
    return Parameters{
        parameter("alpha", &Bearing::alpha, "rad", half, "angle up to which the target counts as in view"),
        parameter("width", &Bearing::width, "m", above_zero, "nearer than this to the sensor l is smoothed"),
        parameter("tilt", &Bearing::tilt, "rad", small, "to the left, of the axis with the target behind")};
  }

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    check_mount(name, mount);
  }

  template <class S>
  S operator()(const Sight<S>& observer, const Sight<S>& target) const {
    const SensorMount straight = {
        .pitch = 0.0, .offset = mount.offset, .frame = mount.frame, .yaw = mount.yaw};
    const Vec3<S> p_V = straight(observer, target.p);
    const S level = square(p_V.x) + square(p_V.y) + square(width);
    const S omega = tilt * logistic(-40.0 * (0.906 + p_V.x * (1.0 / sqrt(level))));
    const S ahead = p_V.x * cos(omega) + p_V.y * sin(omega);
    return 1.0 - (cos(mount.pitch) * ahead - sin(mount.pitch) * p_V.z) * (1.0 / sqrt(level + square(p_V.z)));
  }

  /// Angle by which the target is out of view: alpha_t - alpha [rad], (71).
  double violation(const Sight<double>& observer, const Sight<double>& target) const {
    return view_angle(mount, observer, target.p) - alpha;
  }
};

// Position bounds of a single robot, derived by the workflow of section 5.

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
    return Parameters{
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
    return Parameters{
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

// Potentials that limit the distance of two robots, by a sigmoid step.

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
    return Parameters{parameter("d_min", &KeepOut::d_min, "m", above_zero, "least distance"),
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
    return Parameters{parameter("d_max", &Cohesion::d_max, "m", above_zero, "greatest distance"),
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

// Common limits of one robot, for a RelaxedBarrier. Each is scaled so that c is -1 farthest from
// its borders.

/// Keeps the horizontal speed v of a robot in G between two bounds, min^2 <= v^2 = v_x^2 + v_y^2 <=
/// max^2.
///
///   c = v^2 / max^2 - 1                                     min = 0
///   c = ((2 v^2 - max^2 - min^2) / (max^2 - min^2))^2 - 1   min > 0, for fixed-wing aircraft
///
/// For a multirotor v^2 is v_f^2 + v_s^2.
struct SpeedLimit {
  double max = 1.0;
  double min = 0.0;

  static constexpr std::string_view name = "speed";
  static constexpr auto parameters() {
    return Parameters{parameter("max", &SpeedLimit::max, "m/s", above_zero, "greatest horizontal speed"),
                      parameter("min", &SpeedLimit::min, "m/s", from_zero, "least, below max")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    require(min < max, name, "min", min, "below max");
  }

  template <class S>
  S operator()(const Sight<S>& robot) const {
    const S v2 = square(robot.v.x) + square(robot.v.y);
    if (min == 0) return v2 * (1.0 / square(max)) - 1.0;
    const double low = square(min), high = square(max);
    return square((2.0 * v2 - (high + low)) * (1.0 / (high - low))) - 1.0;
  }
};

/// Keeps two inputs of a robot within a disc, for example u_f and u_s of a multirotor, which set
/// its tilt.
///
///   c = (u_i^2 + u_j^2) / radius^2 - 1
struct InputDisc {
  double radius = 1.0;
  int i = 0, j = 1;

  static constexpr std::string_view name = "input_disc";
  static constexpr auto parameters() {
    constexpr Bounds place = {0.0, 1000.0, "0 to 1000"};
    return Parameters{parameter("radius", &InputDisc::radius, "", above_zero, "in the unit of the inputs"),
                      parameter("i", &InputDisc::i, "", place, "the one input, from 0; of a multirotor u_f"),
                      parameter("j", &InputDisc::j, "", place, "the other; of a multirotor u_s")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const {
    check_parameters(*this);
    require(j != i, name, "j", j, "another input than i");
  }

  int inputs() const { return std::max(i, j) + 1; }

  template <class S>
  S operator()(std::span<const S> /*x*/, std::span<const S> u) const {
    const S &a = u[static_cast<std::size_t>(i)], &b = u[static_cast<std::size_t>(j)];
    return (a * a + b * b) * (1.0 / square(radius)) - 1.0;
  }
};

// Potentials of distance and relative velocity whose gradient does not vanish while the limit is
// violated. docs/equations.md, 13.

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
    return Parameters{
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
    return Parameters{
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
    return Parameters{parameter("v_0", &RelativeVelocity::v_0, "m/s", above_zero, "velocity that costs 1")};
  }
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const { check_parameters(*this); }

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b) const {
    const Vec3<S> v = a.v - b.v;
    return (1.0 / square(v_0)) * dot(v, v);
  }
};

// Keeps passing robots apart, each on its right, so that head-on encounters end in no deadlock.
// docs/equations.md, 14.

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
    return Parameters{
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

// User-defined potential, from limits as text: inequalities, unit step, slope, sigmoid (section
// 5).
//
//   const Region sonar = Region(all_of({"bearing < half_angle", "0.3 m < range < 6 m"}),
//                               {{"half_angle", "20 deg"}}).slope(Softplus{}).sigmoid(5.0);
//
// A formula may use (docs/potentials.md defines the language and the mathematics)
//
//   x, y, z                    the target in the sensor frame S, x on the axis, y left, z up [m]
//   range, bearing             its distance from the sensor [m] and its angle from the axis [rad]
//   azimuth, elevation         its angles in S, to the left and up [rad]
//   r_x, r_y, r_z, distance    from observer to target in G, and its length [m]
//   observer.p_x .. p_z        position in G [m]
//   observer.d_x, .d_y         heading in G
//   observer.v_x .. v_z        velocity in G [m/s]
//   observer.lean_f, .lean_s   tangents of the tilt, forward and to the left
//   target.p_x .. .lean_s      the same of the target
//   t                          the time [s]
//   third.p_x .. p_z           a third body of the coupling, such as an occluding one, in G [m]

/// A comparison as text, or a nested combination of them.
struct Limits {
  enum class Kind { limit, all_of, any_of, opposite };

  Kind kind = Kind::limit;
  std::string text;           ///< of a limit: "range < 4 m"
  std::string grows_with{};   ///< of a limit: formula that scales its quadratic slope; empty: that of the
                              ///< slope
  std::vector<Limits> parts;  ///< of the other kinds; `opposite` has one

  Limits(std::string limit, std::string grows = {}) : text(std::move(limit)), grows_with(std::move(grows)) {}
  Limits(const char* limit) : Limits(std::string(limit)) {}
  Limits(Kind of, std::vector<Limits> these) : kind(of), parts(std::move(these)) {}
};

/// Conjunction, disjunction and negation of limits: `not all_of({"x > 0 m", "range < 4 m"})`.
Limits all_of(std::vector<Limits> parts);
Limits any_of(std::vector<Limits> parts);
Limits operator!(Limits limits);

/// A named number or formula; a number may have a range.
struct Parameter {
  std::string name, text;
  std::string low{}, high{};  ///< formulas of the bounds; empty: none

  Parameter(std::string called, std::string formula, std::string least = {}, std::string most = {})
      : name(std::move(called)), text(std::move(formula)), low(std::move(least)), high(std::move(most)) {}
  Parameter(std::string called, double value);
};

/// Value 1 outside a limit; the gradient is zero except at the limit, (30), (33).
struct NoSlope {};
/// Slope of the paper: kappa_H + kappa_G grows_with outside a limit, (34).
struct Quadratic {
  double kappa_G = 0.01;               ///< >= 0 [1 / unit of `grows_with`]
  std::string grows_with = "range^2";  ///< formula; a limit may have its own
  double kappa_H = 1.0;                ///< height of the step, > 0
};
/// kappa_H + kappa_G c outside a limit c <= 0. The smooth form is the integral of the sigmoid,
/// whose gradient never vanishes.
struct Softplus {
  double kappa_G = 1.0;  ///< > 0 [1 / unit of the limit]
  double kappa_H = 1.0;  ///< height of the step, >= 0
};
using Slope = std::variant<NoSlope, Quadratic, Softplus>;

/// Maximum nesting of all_of, any_of and not, and maximum number of limits.
inline constexpr int region_depth_max = 16;
inline constexpr std::size_t region_limits_max = 64;
/// Maximum number of operations of all limits together.
inline constexpr std::size_t region_steps_max = 2000;

class Region {
 public:
  /// @throws FormulaError if a text is not a formula; std::invalid_argument for a parameter out of
  /// range or too many limits
  Region(const Limits& inside, const std::vector<Parameter>& parameters = {});

  /// The same region with another slope; default NoSlope.
  Region slope(Slope slope) const;
  /// The same region with this sharpness [1 / unit of the limits]; default 1.
  Region sigmoid(double kappa_A) const;
  /// The same region with this sensor mount on the observer.
  Region seen_from(const SensorMount& mount) const;
  /// The same region with another smoothing width, in the unit of the smoothed function; default
  /// 1e-3. It smooths roots, and with them abs, min, max and norm.
  Region smoothed_over(double width) const;
  Region named(std::string name) const;

  /// l [-], which the solver uses: with the sigmoid as the step.
  double operator()(const Sight<double>& observer, const Sight<double>& target, double t) const;
  Symbol operator()(const Sight<Symbol>& observer, const Sight<Symbol>& target, const Symbol& t) const;

  /// 0 inside the region and 1 outside, (29), from the unsmoothed inequalities.
  double unit_step(const Sight<double>& observer, const Sight<double>& target, double t) const;
  /// The unit step with its slope, (34).
  double sloped(const Sight<double>& observer, const Sight<double>& target, double t) const;
  /// > 0 outside: the largest c of all_of, the smallest of any_of, each in its own unit. Never
  /// throws or allocates.
  double violation(const Sight<double>& observer, const Sight<double>& target, double t) const noexcept;

  const std::string& name() const { return name_; }
  static constexpr std::string_view limit_unit = "in the unit of its formula";
  double kappa_A() const { return kappa_A_; }
  const SensorMount& mount() const { return mount_; }
  double width() const { return width_; }
  /// Whether a limit depends on the target in the sensor frame: x, y, z or a quantity derived from
  /// them.
  bool is_view() const;
  /// Whether a formula depends on the position of a third body.
  bool sees_third() const;
  /// Each of the limits that all have to hold, as a region of its own; a copy of itself if there is
  /// one.
  std::vector<Region> conjuncts() const;
  /// Names of the functions whose corners are smoothed.
  std::set<std::string> smoothed() const;
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;

  /// The names that a formula with these parameters may use.
  /// @throws as the constructor
  static Vocabulary vocabulary(const std::vector<Parameter>& parameters);

 private:
  struct Leaf {
    Expression c;
    Expression grows;
    bool grows_by_itself;
  };
  /// all_of or any_of of parts, or a leaf.
  struct Part {
    Limits::Kind kind;
    std::size_t leaf = 0;
    std::vector<Part> parts{};
  };
  struct Parsed {
    Vocabulary names;
    std::vector<Leaf> leaves;
    Part root;
    std::size_t steps = 0;
  };
  template <class S>
  struct Beyond;

  static Part read(Parsed& parsed, const Limits& limits, bool opposite, int depth);
  template <class Step, class S>
  Beyond<S> evaluate(const Part& part, const Step& eps, std::span<const S> variables) const;
  template <class Step, class S>
  S over(const Step& eps, const Sight<S>& observer, const Sight<S>& target, const S& t) const;
  /// @param scratch  one value per step of a leaf
  double excess(const Part& part, std::span<const double> variables,
                std::span<double> scratch) const noexcept;
  template <class S>
  using Variables = std::array<S, 6 + 2 * sight_size + 1 + 3>;  // x, y, z, r, both sights, t, the third body
  template <class S>
  Variables<S> variables(const Sight<S>& observer, const Sight<S>& target, const S& t) const;

  std::shared_ptr<const Parsed> parsed_;
  Slope slope_{};
  Expression grows_{};  // of the slope
  double kappa_A_ = 1.0, width_ = 1e-3;
  SensorMount mount_{};
  std::string name_ = "region";
};

// Potential of a cone-shaped field of view.

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
    return Parameters{
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
