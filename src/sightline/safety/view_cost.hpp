/// The set S of a ViewCertificate as soft limits of a solver, so that the filter acts rarely.
///
///   l = sum of ln(1 + e^(kappa (1 - g / m))) / kappa over the reserves g of S
///
/// The margin m of a reserve is what the filter keeps of it free from its own action: the greatest loss
/// of a second by the target's motion, divided by the filter's decay rate, and at most 0.45 of the
/// width. The braking distance is y^2 / (2 b), and lo and hi are parallel lines. Both lie inside S.
#pragma once

#include <cmath>
#include <string_view>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/safety/view_certificate.hpp"

namespace sightline {

class ViewCost {
 public:
  explicit ViewCost(const ViewCertificate& certificate);

  static constexpr std::string_view name = "certified_view", limit_unit = "m";
  static constexpr bool observes = false, keeps_apart = false;
  /// Its weight, as a part of the greatest one among the limits of the pair.
  static constexpr double weight = 0.25;

  template <class S>
  S operator()(const Sight<S>& robot, const Sight<S>& target) const {
    using std::atan2, std::sqrt;
    constexpr double kappa = 8.0;
    const auto beyond = [](const S& reserve, double margin) {
      return softplus(S(kappa * (1.0 - reserve / margin))) / kappa;
    };
    const auto brake = [this](const S& v) {
      constexpr double corner = 0.05;  // [m/s]
      const S y = v + speed_;
      return square(0.5 * (y + sqrt(square(y) + square(corner)))) / (2 * thrust_);
    };
    const Vec2<double>& axis = z_.task.motion.ahead;
    const bool is_nose = axis.x == 1;
    const Vec2<S> d = is_nose ? robot.d : rotate(robot.d, Vec2<S>{S(axis.x), S(axis.y)});
    const S x = target.p.x - robot.p.x, y = target.p.y - robot.p.y;
    const S ahead = d.x * x + d.y * y, left = d.x * y - d.y * x;
    const S r = sqrt(square(x) + square(y) + S(1e-6)), theta = atan2(left, ahead);
    const S v_x = robot.v.x - measured_ * target.v.x, v_y = robot.v.y - measured_ * target.v.y;
    const S v_f = d.x * v_x + d.y * v_y, v_s = d.x * v_y - d.y * v_x;
    const S h = robot.p.z - target.p.z - slope_ * r;
    S sum = beyond(r - z_.near - brake(v_f), range_) + beyond(z_.far - r - brake(-v_f), range_) +
            beyond(z_.theta - theta, bearing_) + beyond(z_.theta + theta, bearing_);
    if (z_.task.motion.climb.input >= 0) sum += beyond(high_ - h, height_) + beyond(h - low_, height_);
    if (z_.task.motion.across.input >= 0)
      sum += beyond(z_.sideward - v_s, sideward_) + beyond(z_.sideward + v_s, sideward_);
    return sum;
  }

  /// Distance by which a state is outside S; bearings count by their arc, velocities not.
  double violation(const Sight<double>& robot, const Sight<double>& target) const noexcept;

 private:
  ViewCertificate z_;
  double measured_;                             // 1 if the velocity is relative to the target's
  double speed_, thrust_;                       // W_e, and b - c W_e
  double slope_, low_, high_;                   // the height is between low + slope r and high + slope r
  double range_, bearing_, height_, sideward_;  // margins
};

}  // namespace sightline
