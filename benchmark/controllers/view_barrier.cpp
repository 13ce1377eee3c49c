#include "benchmark/controllers/view_barrier.hpp"

#include <algorithm>
#include <cmath>

namespace sightline::benchmark {
namespace {

Pose<double> pose_of(const double* x) { return {{x[0], x[1], x[2]}, {x[3], x[4]}}; }

}  // namespace

Barrier view_barrier(const SensorMount& mount, double alpha, const Vec3<double>& q) {
  const Vec3<double> p = mount(Pose<double>{{0, 0, 0}, {1, 0}}, q);
  constexpr double least = 1e-6;  // the direction is undefined at the sensor [m]
  const double length = std::max(norm(p), least), share = std::cos(alpha) / length;
  return {p.x - std::cos(alpha) * length,
          mount.attitude() * Vec3<double>{1 - share * p.x, -share * p.y, -share * p.z}};
}

Barrier distance_barrier(const Vec3<double>& q, double d, double sign) {
  return {sign * (dot(q, q) - d * d), (2 * sign) * q};
}

BarrierRow row_of(const Barrier& barrier, const Relative& body, double gamma) {
  const Vec3<double>& g = barrier.gradient;
  return {{-g.x, -g.y, -g.z, g.x * body.q.y - g.y * body.q.x}, -gamma * barrier.h - dot(g, body.w)};
}

ViewBarrierLaw::ViewBarrierLaw(const Team& team, const ViewTask& task, const ViewBarrierOptions& options)
    : task_(task), options_(options), loop_(team.model(task.robot)), best_(best_place(task)) {}

Status ViewBarrierLaw::inputs(const double* x, std::span<const Sight<double>> bodies,
                              std::span<double> u) noexcept {
  const ViewBarrierOptions& o = options_;
  const Relative target = relative(pose_of(x), bodies[0]);
  const double level = std::hypot(target.q.x, target.q.y);
  // Tracking: the distance along the direction to the target, its height, its velocity, and the bearing.
  const double radial = o.k_p * (level - std::hypot(best_.x, best_.y)) / std::max(level, 1e-6);
  const std::array<double, 4> wanted = {
      target.w.x + radial * target.q.x, target.w.y + radial * target.q.y,
      target.w.z + o.k_p * (target.q.z - best_.z),
      o.k_yaw * wrap(std::atan2(target.q.y, target.q.x) - std::atan2(best_.y, best_.x))};

  std::array<BarrierRow, rows_max> rows = {
      row_of(view_barrier(task_.mount, task_.alpha, target.q), target, o.gamma),
      row_of(distance_barrier(target.q, task_.d_min, 1), target, o.gamma),
      row_of(distance_barrier(target.q, task_.d_max, -1), target, o.gamma)};
  // The other body whose barrier is least.
  std::size_t count = 3;
  double least = infinity;
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    const Relative other = relative(pose_of(x), bodies[i]);
    const Barrier barrier = distance_barrier(other.q, task_.others[i - 1].d_min, 1);
    if (barrier.h >= least) continue;
    least = barrier.h, count = 4;
    rows[3] = row_of(barrier, other, o.gamma);
  }

  const std::array<double, 4> v =
      nearest_within(wanted, {1.0, 1.0, 1.0, 1.0}, std::span(rows).first(count), o.rho);
  const double speed = std::hypot(v[0], v[1]), share = speed > o.v_max ? o.v_max / speed : 1.0;
  const Input command = loop_.inputs(x, {share * v[0], share * v[1], v[2], v[3]}, o.tau);
  std::copy(command.begin(), command.end(), u.begin());
  return Status::converged;
}

}  // namespace sightline::benchmark
