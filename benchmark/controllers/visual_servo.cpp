#include "benchmark/controllers/visual_servo.hpp"

#include <algorithm>
#include <cmath>

namespace sightline::benchmark {

Vec3<double> features(const Vec3<double>& p_S) { return {p_S.y / p_S.x, p_S.z / p_S.x, std::log(p_S.x)}; }

Mat<3, 4> interaction(const SensorMount& mount, const Vec3<double>& s) {
  const double depth = std::exp(s.z);
  const Vec3<double> p_V = mount.point_in_F({depth, depth * s.x, depth * s.y});
  // Velocities of the point in V, then in S, for one unit of each command.
  const std::array<Vec3<double>, 4> moves = {Vec3<double>{-1, 0, 0}, Vec3<double>{0, -1, 0},
                                             Vec3<double>{0, 0, -1}, Vec3<double>{p_V.y, -p_V.x, 0}};
  const Mat<3, 3> R_SV = transposed(mount.attitude());
  Mat<3, 4> J;
  for (int j = 0; j < 4; ++j) {
    const Vec3<double> v = R_SV * moves[at(j)];
    J(0, j) = (v.y - s.x * v.x) / depth;
    J(1, j) = (v.z - s.y * v.x) / depth;
    J(2, j) = v.x / depth;
  }
  return J;
}

VisualServoLaw::VisualServoLaw(const Team& team, const ViewTask& task, const VisualServoOptions& options)
    : task_(task),
      options_(options),
      loop_(team.model(task.robot)),
      wanted_(features(task.mount(Pose<double>{{0, 0, 0}, {1, 0}}, best_place(task)))) {}

Status VisualServoLaw::inputs(const double* x, std::span<const Sight<double>> bodies,
                              std::span<double> u) noexcept {
  const VisualServoOptions& o = options_;
  const Vec3<double> p = task_.mount(Pose<double>{{x[0], x[1], x[2]}, {x[3], x[4]}}, bodies[0].p);
  VelocityCommand command;
  if (off_axis(p) > o.field) {
    command.yaw = side_ * o.turn;
  } else {
    if (p.y != 0) side_ = p.y > 0 ? 1.0 : -1.0;
    const Vec3<double> s = features(p);
    const Mat<3, 4> J = interaction(task_.mount, s);
    // The least weighted velocity with J v = -lambda (s - s*).
    Mat<4, 3> back = transposed(J);
    for (int j = 0; j < 3; ++j) back(1, j) /= o.sideward;
    const Cholesky<3> factor(J * back + identity<3>(1e-9));
    if (!factor.positive) return Status::not_finite;
    const Column<4> v = back * factor.solve(column((-o.lambda) * (s - wanted_)));
    const double speed = std::hypot(v(0, 0), v(1, 0)), share = speed > o.v_max ? o.v_max / speed : 1.0;
    command = {share * v(0, 0), share * v(1, 0), v(2, 0), v(3, 0)};
  }
  const Input inputs = loop_.inputs(x, command, o.tau);
  std::copy(inputs.begin(), inputs.end(), u.begin());
  return Status::converged;
}

}  // namespace sightline::benchmark
