#include "benchmark/controllers/mpc_laws.hpp"

#include <algorithm>
#include <cmath>

#include "benchmark/controllers/view_barrier.hpp"

namespace sightline::benchmark {
namespace {

Pose<double> pose_of_state(const State& x) { return {{x[0], x[1], x[2]}, {x[3], x[4]}}; }

}  // namespace

std::array<double, 2> projection(const Vec3<double>& p_S, double width) {
  const double depth = 0.5 * (p_S.x + std::sqrt(p_S.x * p_S.x + width * width));
  return {p_S.y / depth, p_S.z / depth};
}

double barrier_shortfall(double h, double h_next, double gamma) {
  return std::max(0.0, (1 - gamma) * h - h_next);
}

MpcLaw::MpcLaw(const Team& team, const Horizon& horizon, const ViewTask& task, const MpcOptions& options)
    : task_(task),
      weights_(options),
      robot_(team.model(task.robot)),
      mpc_(robot_, horizon),
      best_(best_place(task)),
      h_(horizon.h()) {
  team.agent(task.robot).limits.at(0.0, u_min_, u_max_);
}

Relative MpcLaw::seen(std::size_t body, int k, const State& x) const noexcept {
  Sight<double> then = bodies_[body];
  then.p = then.p + (k * h_) * then.v;
  return relative(pose_of_state(x), then);
}

Residuals MpcLaw::tracking(int k, const Input& u, const State& next) const noexcept {
  const MpcOptions& o = weights_;
  const Relative target = seen(0, k + 1, next);
  Residuals r{};
  for (std::size_t i = 0; i < nu; ++i) r[i] = o.input * u[i];
  r[4] = o.range * (std::hypot(target.q.x, target.q.y) - std::hypot(best_.x, best_.y));
  r[5] = o.height * (target.q.z - best_.z);
  r[6] = o.velocity * (next[5] - target.w.x);
  r[7] = o.velocity * (next[6] - target.w.y);
  return r;
}

Status MpcLaw::inputs(const double* x, std::span<const Sight<double>> bodies, std::span<double> u) noexcept {
  constexpr int start_steps = 10;
  bodies_ = bodies;
  const Status status = mpc_.update(x, *this, u_min_, u_max_, begun_ ? 1 : start_steps);
  bodies_ = {};
  begun_ = gives_plan(status);
  std::copy(mpc_.first().begin(), mpc_.first().end(), u.begin());
  return status;
}

PerceptionLaw::PerceptionLaw(const Team& team, const Horizon& horizon, const ViewTask& task,
                             const PerceptionOptions& options)
    : MpcLaw(team, horizon, task, options), options_(options) {}

Residuals PerceptionLaw::operator()(int k, const State& x, const Input& u, const State& next) const noexcept {
  Residuals r = tracking(k, u, next);
  const Vec3<double> q = seen(0, k, x).q, q_next = seen(0, k + 1, next).q;
  const auto image = [&](const Vec3<double>& place) {
    return projection(task_.mount(Pose<double>{{0, 0, 0}, {1, 0}}, place), options_.depth);
  };
  const std::array<double, 2> s = image(q), s_next = image(q_next);
  for (std::size_t i = 0; i < 2; ++i) {
    r[8 + i] = options_.image * s_next[i];
    r[10 + i] = options_.image_velocity * (s_next[i] - s[i]) / h();
  }
  r[12] = weights().near * std::max(0.0, task_.d_min - norm(q_next));
  for (std::size_t i = 1; i < bodies(); ++i) {
    const double below = task_.others[i - 1].d_min - norm(seen(i, k + 1, next).q);
    r[13] = std::max(r[13], weights().near * below);
  }
  return r;
}

BarrierMpcLaw::BarrierMpcLaw(const Team& team, const Horizon& horizon, const ViewTask& task,
                             const BarrierMpcOptions& options)
    : MpcLaw(team, horizon, task, options), options_(options) {}

Residuals BarrierMpcLaw::operator()(int k, const State& x, const Input& u, const State& next) const noexcept {
  Residuals r = tracking(k, u, next);
  const Vec3<double> q = seen(0, k, x).q, q_next = seen(0, k + 1, next).q;
  const double alpha = options_.margin * task_.alpha;
  const auto shortfall = [&](const Barrier& now, const Barrier& then) {
    return options_.penalty * barrier_shortfall(now.h, then.h, options_.gamma);
  };
  r[8] = shortfall(view_barrier(task_.mount, alpha, q), view_barrier(task_.mount, alpha, q_next));
  r[9] = shortfall(distance_barrier(q, task_.d_min, 1), distance_barrier(q_next, task_.d_min, 1));
  r[10] = shortfall(distance_barrier(q, task_.d_max, -1), distance_barrier(q_next, task_.d_max, -1));
  for (std::size_t i = 1; i < bodies(); ++i) {
    const double d = task_.others[i - 1].d_min;
    r[11] = std::max(r[11], shortfall(distance_barrier(seen(i, k, x).q, d, 1),
                                      distance_barrier(seen(i, k + 1, next).q, d, 1)));
  }
  return r;
}

}  // namespace sightline::benchmark
