#include "sightline/safety/view_cost.hpp"

#include <algorithm>
#include <cmath>

namespace sightline {

ViewCost::ViewCost(const ViewCertificate& z)
    : z_(z),
      measured_(z.task.bounds.is_velocity_measured() ? 1.0 : 0.0),
      speed_(z.brake.speed),
      thrust_(z.brake.thrust) {
  constexpr double rate = 4.0;     // of the filter [1/s]
  constexpr double widest = 0.45;  // part of a width
  const auto margin = [](double loss, double width, double least) {
    return std::clamp(loss / rate, least, std::max(least, widest * width));
  };
  const double rest = z.brake.distance(0.0), middle = 0.5 * (z.near + z.far);
  const ViewBounds& bounds = z.task.bounds;
  const ViewBounds::Known known = bounds.known(z.task.dt);
  const double speed = (1 - measured_) * known.speed + view_prediction(bounds, z.task.dt).speed,
               push = bounds.wind + (measured_ > 0 ? bounds.acceleration : 0.0);
  range_ = margin(speed_ + push * z.brake.slope(0.0), z.far - z.near - 2 * rest, 0.02);
  bearing_ = margin(speed / middle, z.theta, 0.02);
  sideward_ = margin(z.sideward, z.sideward, 0.01);

  // The line through the middle of the heights at which a robot at rest may be.
  double n = 0, sum_r = 0, sum_h = 0, sum_rr = 0, sum_rh = 0;
  const auto at_rest = [&](auto&& visit) {
    for (std::size_t k = 0; k < z.low.size(); ++k) {
      const double r = z.near + static_cast<double>(k) * z.step();
      if (r >= z.near + rest && r <= z.far - rest) visit(r, z.low[k], z.high[k]);
    }
  };
  at_rest([&](double r, double low, double high) {
    const double h = 0.5 * (low + high);
    n += 1, sum_r += r, sum_h += h, sum_rr += r * r, sum_rh += r * h;
  });
  const double spread = n * sum_rr - square(sum_r);
  slope_ = spread > 1e-9 ? (n * sum_rh - sum_r * sum_h) / spread : 0.0;
  const double line =
      n > 0 ? (sum_h - slope_ * sum_r) / n : 0.5 * (z.at(z.low, middle) + z.at(z.high, middle));
  double half = infinity;
  at_rest([&](double r, double low, double high) {
    half = std::min({half, line + slope_ * r - low, high - line - slope_ * r});
  });
  half = std::isfinite(half) ? std::max(half, 0.01) : 0.01;
  low_ = line - half, high_ = line + half;
  height_ = margin(known.climb + std::abs(slope_) * speed_, half, 0.01);
}

double ViewCost::violation(const Sight<double>& robot, const Sight<double>& target) const noexcept {
  const Vec2<double> ahead = rotate(robot.d, z_.task.motion.ahead), back = {ahead.x, -ahead.y};
  const Vec2<double> q = rotate(back, {target.p.x - robot.p.x, target.p.y - robot.p.y});
  const Vec2<double> v =
      rotate(back, {robot.v.x - measured_ * target.v.x, robot.v.y - measured_ * target.v.y});
  const double r = norm(q.x, q.y), h = robot.p.z - target.p.z;
  return std::max({z_.near + z_.brake.distance(v.x) - r, r + z_.brake.distance(-v.x) - z_.far,
                   (std::abs(std::atan2(q.y, q.x)) - z_.theta) * r, h - z_.at(z_.high, r),
                   z_.at(z_.low, r) - h});
}

}  // namespace sightline
