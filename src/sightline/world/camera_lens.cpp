#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/sensors.hpp"

namespace sightline {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int iterations_most = 100;
constexpr double same_place = 1e-9;  // in focal lengths

/// The coefficients with 0 for those that are left out.
struct Lens {
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0, k4 = 0.0, k5 = 0.0, k6 = 0.0;

  explicit Lens(const Camera& camera) {
    const std::vector<double>& c = camera.coefficients;
    const auto at = [&](std::size_t i) { return i < c.size() ? c[i] : 0.0; };
    if (camera.distortion == Distortion::equidistant) {
      k1 = at(0), k2 = at(1), k3 = at(2), k4 = at(3);
    } else {
      k1 = at(0), k2 = at(1), p1 = at(2), p2 = at(3), k3 = at(4), k4 = at(5), k5 = at(6), k6 = at(7);
    }
  }

  /// The factor g of r^2 = s, and its derivative by s.
  Vec2<double> factor(double s) const {
    const double above = 1 + s * (k1 + s * (k2 + s * k3)), below = 1 + s * (k4 + s * (k5 + s * k6));
    const double of_above = k1 + s * (2 * k2 + 3 * s * k3), of_below = k4 + s * (2 * k5 + 3 * s * k6);
    return {above / below, (of_above * below - above * of_below) / (below * below)};
  }
  /// theta_d, and its derivative by theta.
  Vec2<double> angle(double theta) const {
    const double s = theta * theta;
    return {theta * (1 + s * (k1 + s * (k2 + s * (k3 + s * k4)))),
            1 + s * (3 * k1 + s * (5 * k2 + s * (7 * k3 + 9 * s * k4)))};
  }
  /// (x_d, y_d) of a point of the plane at depth 1.
  Vec2<double> of(double x, double y) const {
    const double s = x * x + y * y, g = factor(s).x;
    return {x * g + 2 * p1 * x * y + p2 * (s + 2 * x * x), y * g + p1 * (s + 2 * y * y) + 2 * p2 * x * y};
  }
  /// Derivatives of of() by x, and by y.
  std::array<Vec2<double>, 2> slopes(double x, double y) const {
    const Vec2<double> g = factor(x * x + y * y);
    const double across = 2 * (x * y * g.y + p1 * x + p2 * y);
    return {{{g.x + 2 * x * x * g.y + 2 * p1 * y + 6 * p2 * x, across},
             {across, g.x + 2 * y * y * g.y + 6 * p1 * y + 2 * p2 * x}}};
  }
};

/// Distance of an image from the axis, in focal lengths, and its derivative, by theta or by r.
Vec2<double> radius(const Camera& camera, const Lens& lens, double theta) {
  if (camera.distortion == Distortion::equidistant) return lens.angle(theta);
  const double r = std::tan(theta);
  const Vec2<double> g = lens.factor(r * r);
  return {r * g.x, g.x + 2 * r * r * g.y};
}

/// The angle from the axis of an image at this distance from it: a root that is bracketed.
std::optional<double> angle_at(const Camera& camera, const Lens& lens, double distance, double widest) {
  double low = 0.0, high = widest;
  if (!(distance >= 0 && distance <= radius(camera, lens, high).x)) return std::nullopt;
  for (int i = 0; i < iterations_most && high - low > 1e-15; ++i) {
    const double middle = 0.5 * (low + high);
    (radius(camera, lens, middle).x < distance ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Scale {
  double fx, fy, cx, cy;  // c from the middle of the picture

  explicit Scale(const Camera& c)
      : fx(c.focal_length[0] > 0 ? c.focal_length[0] : c.focal()),
        fy(c.focal()),
        cx(c.principal_point[0] > 0 ? c.principal_point[0] - 0.5 * c.width : 0.0),
        cy(c.principal_point[1] > 0 ? c.principal_point[1] - 0.5 * c.height : 0.0) {}
};

}  // namespace

double Camera::focal() const {
  if (focal_length[1] > 0) return focal_length[1];
  if (distortion == Distortion::equidistant) return height / field_of_view;
  const SinCos<double> half = sincos(0.5 * field_of_view);
  return 0.5 * height * half.cos / half.sin;
}

Vec2<double> Camera::distorted(const Vec3<double>& p_S) const {
  const Lens lens(*this);
  const Scale to(*this);
  const double right = -p_S.y, down = -p_S.z;
  Vec2<double> d;
  if (distortion == Distortion::equidistant) {
    const double across = norm(right, down);
    const double q = across > 0 ? lens.angle(std::atan2(across, p_S.x)).x / across : 1 / p_S.x;
    d = {q * right, q * down};
  } else {
    d = lens.of(right / p_S.x, down / p_S.x);
  }
  return {to.fx * d.x + to.cx, to.fy * d.y + to.cy};
}

std::array<Vec3<double>, 2> Camera::slopes(const Vec3<double>& p_S) const {
  const double near = 1 / p_S.x;
  if (is_plain()) {
    const double f = focal();
    return {{{f * p_S.y * near * near, -f * near, 0}, {f * p_S.z * near * near, 0, -f * near}}};
  }
  const Lens lens(*this);
  const Scale to(*this);
  const double right = -p_S.y, down = -p_S.z;
  if (distortion != Distortion::equidistant) {
    const auto [by_x, by_y] = lens.slopes(right * near, down * near);
    const double x = right * near, y = down * near;
    const auto row = [&](double f, double of_x, double of_y) {
      return Vec3<double>{-f * near * (of_x * x + of_y * y), -f * near * of_x, -f * near * of_y};
    };
    return {row(to.fx, by_x.x, by_y.x), row(to.fy, by_x.y, by_y.y)};
  }
  // x_d = q right with q = theta_d / across, theta = atan2(across, ahead).
  const double across = norm(right, down), square_of_distance = square(across) + square(p_S.x);
  if (!(across > 1e-9 * p_S.x)) return {{{0, -to.fx * near, 0}, {0, 0, -to.fy * near}}};
  const Vec2<double> theta_d = lens.angle(std::atan2(across, p_S.x));
  const double q = theta_d.x / across;
  const double by_ahead = -theta_d.y / square_of_distance;  // d q / d ahead
  const double by_across = (theta_d.y * p_S.x / square_of_distance - q) / (across * across);
  const auto row = [&](double f, double side, double of_right, double of_down) {
    return Vec3<double>{f * side * by_ahead, -f * (side * right * by_across + of_right),
                        -f * (side * down * by_across + of_down)};
  };
  return {row(to.fx, right, q, 0.0), row(to.fy, down, 0.0, q)};
}

double Camera::widest() const {
  if (distortion == Distortion::none) return pi / 2;
  constexpr int steps = 500;
  const Lens lens(*this);
  const double most = distortion == Distortion::equidistant ? pi : pi / 2 - 0.01;
  double last = 0.0;
  for (int i = 1; i <= steps; ++i) {
    const Vec2<double> at = radius(*this, lens, most * i / steps);
    if (!(at.x > last && at.y > 0)) return most * (i - 1) / steps;
    last = at.x;
  }
  return most;
}

bool Camera::sees(const Vec3<double>& p_S, double widest) const {
  if (!(depth(p_S) > nearest_depth)) return false;
  return distortion == Distortion::none || std::atan2(norm(p_S.y, p_S.z), p_S.x) <= widest;
}

std::optional<Vec3<double>> Camera::ray(const Vec2<double>& at) const {
  const Lens lens(*this);
  const Scale from(*this);
  const double most = widest();
  const Vec2<double> d = {(at.x - from.cx) / from.fx, (at.y - from.cy) / from.fy};
  const double distance = norm(d.x, d.y);
  const auto direction = [&](double theta, double x, double y) -> Vec3<double> {
    const double across = norm(x, y), s = across > 0 ? std::sin(theta) / across : 0.0;
    return {std::cos(theta), -s * x, -s * y};
  };
  if (distortion == Distortion::none) return direction(std::atan(distance), d.x, d.y);
  const std::optional<double> theta = angle_at(*this, lens, distance, most);
  if (distortion == Distortion::equidistant) {
    if (!theta) return std::nullopt;
    return direction(*theta, d.x, d.y);
  }
  // The radial part alone, then Newton steps for the decentering, halved where they overshoot.
  const double scale = distance > 0 ? std::tan(theta.value_or(most)) / distance : 0.0;
  double x = scale * d.x, y = scale * d.y;
  const auto error = [&](double at_x, double at_y) {
    const Vec2<double> now = lens.of(at_x, at_y);
    return Vec2<double>{d.x - now.x, d.y - now.y};
  };
  Vec2<double> e = error(x, y);
  for (int i = 0; i < iterations_most && norm(e.x, e.y) > 1e-3 * same_place; ++i) {
    const auto [by_x, by_y] = lens.slopes(x, y);
    const double det = by_x.x * by_y.y - by_x.y * by_y.x;
    if (!(det > 0)) return std::nullopt;
    Vec2<double> step = {(e.x * by_y.y - e.y * by_y.x) / det, (e.y * by_x.x - e.x * by_x.y) / det};
    while (norm(step.x, step.y) > 1e-15) {
      const Vec2<double> next = error(x + step.x, y + step.y);
      if (norm(next.x, next.y) < norm(e.x, e.y)) break;
      step = {0.5 * step.x, 0.5 * step.y};
    }
    x += step.x, y += step.y;
    e = error(x, y);
  }
  const double angle = std::atan(norm(x, y));
  if (!(norm(e.x, e.y) < same_place && angle <= most)) return std::nullopt;
  return direction(angle, x, y);
}

}  // namespace sightline
